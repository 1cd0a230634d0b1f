// Bundles src/main.js with three.js into the one script that the program embeds: src/viewer/page.min.js.
// `--check` writes nothing and fails when the committed script is not what these sources give.
import { build } from "esbuild";
import { readFileSync, writeFileSync } from "node:fs";

const here = new URL("./", import.meta.url);
const target = new URL("../../src/viewer/page.min.js", here);
const licence = readFileSync(new URL("node_modules/three/LICENSE", here), "utf8").trim();

const result = await build({
  entryPoints: [new URL("src/main.js", here).pathname],
  bundle: true,
  minify: true,
  write: false,
  format: "iife",
  target: "es2020",
  // A script inside a page may not hold the end of a script, and needs no letters beyond ASCII.
  charset: "ascii",
  legalComments: "none",
  banner: { js: `/*! This page is drawn by three.js, https://threejs.org:\n\n${licence}\n*/` },
});
const bundle = result.outputFiles[0].text.replaceAll("</script", "<\\/script");
if (process.argv.includes("--check")) {
  if (readFileSync(target, "utf8") !== bundle) {
    console.error("src/viewer/page.min.js is stale: npm run build --prefix tools/viewer");
    process.exit(1);
  }
} else {
  writeFileSync(target, bundle);
}
console.log(`${Math.round(bundle.length / 1000)} kB`);
