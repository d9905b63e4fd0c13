"""Bakes an array of shares under HyperQueue and prints as JSON which tasks failed.

python3 hyperqueue_jobs.py SERVER_FOLDER SCRIPT OUT TASK[,TASK...] ARGUMENT...

A server and two workers of four processors are started for this array alone. Task numbers are those of `hq submit --array`.
"""

import contextlib
import json
import os
import sys

from hyperqueue import Job
from hyperqueue.cluster import LocalCluster, WorkerConfig
from hyperqueue.ffi.protocol import ResourceRequest

server, script, out, tasks, *arguments = sys.argv[1:]
numbers = [int(task) for task in tasks.split(",")]
# Tables and progress go to stderr: stdout holds the document.
report = os.dup(1)
os.dup2(2, 1)
with LocalCluster(server) as cluster:
    for _ in range(2):
        cluster.start_worker(WorkerConfig(cores=4))
    client = cluster.client()
    job = Job(default_env={"SHATTER_OUT": out, "PATH": os.environ["PATH"]})
    for number in numbers:
        task = job.program([script, *arguments], resources=ResourceRequest(cpus=4))
        job.task_map.pop(task.task_id, None)
        task.task_id = number
        job.task_map[number] = task
    submitted = client.submit(job)
    failed = []
    if not client.wait_for_jobs([submitted], raise_on_error=False):
        failed = sorted(client.get_failed_tasks(submitted))
with contextlib.closing(os.fdopen(report, "w")) as stdout:
    json.dump({"tasks": numbers, "failed": failed}, stdout)
