// Checks glTF files with the Khronos glTF-Validator: node validate.mjs FILE... Prints one line per file and its errors; exits with 1 when
// there is any error, with 77 (ctest: skipped) when the npm package gltf-validator is not installed beside this script, in
// the current folder or in NODE_PATH.
import {readFileSync} from 'node:fs';
import {createRequire} from 'node:module';
import {basename, dirname, join, resolve} from 'node:path';

let validator;
try {
  validator = createRequire(join(process.cwd(), 'validate.mjs'))('gltf-validator');
} catch {
  console.log('skipped: npm package gltf-validator is not installed (npm install gltf-validator)');
  process.exit(77);
}

let errors = 0;
for (const file of process.argv.slice(2)) {
  const report = await validator.validateBytes(new Uint8Array(readFileSync(file)), {
    uri: basename(file),
    maxIssues: 1000,
    externalResourceFunction: (uri) => Promise.resolve(new Uint8Array(readFileSync(resolve(dirname(file), decodeURIComponent(uri))))),
  });
  const {numErrors, numWarnings} = report.issues;
  console.log(`${file}: ${numErrors} errors, ${numWarnings} warnings`);
  for (const issue of report.issues.messages.filter((m) => m.severity === 0)) {
    console.log(`  ${issue.pointer ?? ''} ${issue.code}: ${issue.message}`);
  }
  errors += numErrors;
}
process.exit(errors === 0 ? 0 : 1);
