"""Validates job files against the schema of Kubernetes, without unknown keys, and prints the errors as JSON.

python3 kubernetes_files.py FILE.yaml ...
"""

import json
import sys

import kubernetes_validate
import yaml

version = kubernetes_validate.latest_version()
wrong = []
for path in sys.argv[1:]:
    with open(path, encoding="utf-8") as file:
        for document in yaml.safe_load_all(file):
            try:
                kubernetes_validate.validate(document, version, strict=True)
            except kubernetes_validate.ValidationError as error:
                wrong.append(f"{path}: {'.'.join(map(str, error.path))}: {error.message}")
print(json.dumps({"version": str(version), "files": len(sys.argv) - 1, "wrong": wrong}))
