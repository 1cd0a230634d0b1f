// Usage: node validate.mjs FILE.glb…
//
// One line for each file and one for each error or warning in it. Exit code 0: none anywhere; 1: some; 2: bad use.
import { readFile } from "node:fs/promises";
import { basename } from "node:path";
import validator from "gltf-validator";

const files = process.argv.slice(2);
if (files.length === 0) {
  console.error("usage: node validate.mjs FILE.glb…");
  process.exit(2);
}

const SEVERITY = ["error", "warning"];
let isClean = true;
for (const file of files) {
  let report;
  try {
    const bytes = new Uint8Array(await readFile(file));
    // 0: list every message, or a file with one fault in each vertex would show the first hundred only.
    report = await validator.validateBytes(bytes, { uri: basename(file), maxIssues: 0 });
  } catch (error) {
    console.error(`${file}: cannot be validated: ${error.message ?? error}`);
    process.exit(2);
  }
  const { numErrors, numWarnings, numInfos, messages } = report.issues;
  console.log(`${file}: ${numErrors} errors, ${numWarnings} warnings, ${numInfos} notes`);
  for (const { severity, code, message, pointer } of messages) {
    if (severity < SEVERITY.length) {
      console.log(`  ${SEVERITY[severity]} ${code} at ${pointer ?? "the file"}: ${message}`);
    }
  }
  isClean &&= numErrors + numWarnings === 0;
}
process.exit(isClean ? 0 : 1);
