// The commands that serve a saved scene, and bake the database that it names if that is another one than the object's.

/** Where the database of an object lies, as far as the server of the page knows. */
export interface DatabaseFolder {
  /** `undefined`: another program started the daemon. */
  path: string | undefined;
  /** Whether it is removed when `shatter view` ends. */
  isTemporary: boolean;
}

/** A database that does not exist yet: the same object of another material. */
export interface OtherDatabase {
  name: string;
  material: string;
}

/** A word of a shell. */
export function shellWord(text: string): string {
  return /^[\w./:@%+=-]+$/.test(text) && !text.startsWith("-") ? text : `'${text.replaceAll("'", "'\\''")}'`;
}

/** The commands, one a line. The service has a name of its own: that of the page may still run. */
export function sceneCommands(object: string, folder: DatabaseFolder, other: OtherDatabase | undefined): string {
  const service = shellWord(`${object}-art`);
  const own = shellWord(`${object}.shatter`);
  const given = folder.path === undefined ? "FOLDER" : shellWord(folder.path);
  const path = folder.isTemporary ? "." : given;
  const lines = [];
  if (folder.path === undefined) lines.push("# FOLDER: the folder of databases that the daemon of the page serves");
  if (folder.isTemporary) {
    lines.push("# shatter view removes its own copy of the database when it ends", `cp ${given}/${own} .`);
  }
  if (other) {
    const mesh = shellWord(`${object}.glb`);
    lines.push(
      `# the same shape as a database of ${other.material}`,
      `shatterd inspect ${shellWord(object)} --databases ${path} --mesh ${mesh}`,
      `shatterd bake ${mesh} --name ${shellWord(other.name)} --material ${other.material} --out ${path}`,
    );
  }
  lines.push("# checks the scene, for example after a change:", `shatterd check scene.toml --databases ${path}`);
  lines.push(`shatterd serve --service ${service} --scene scene.toml --databases ${path}`, "# in another terminal:", `shatter view --service ${service}`);
  return lines.join("\n");
}
