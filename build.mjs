// Bundles the browser client: one entry per page, shared code in chunks, no source maps shipped.
import { build } from "esbuild";
import { rm } from "node:fs/promises";

const SOURCES = "web/static";
const OUTPUT = "web/static/dist";

const ENTRIES = ["js/play.js", "js/check.js", "js/form.js", "js/expert.js", "js/staff.js", "js/watch.js", "css/page.css", "css/play.css", "css/expert.css"];

await rm(OUTPUT, { recursive: true, force: true });
await build({
  entryPoints: ENTRIES.map((entry) => `${SOURCES}/${entry}`),
  entryNames: "[name]",
  chunkNames: "chunk-[hash]",
  outdir: OUTPUT,
  bundle: true,
  splitting: true,
  format: "esm",
  target: "es2022",
  minify: true,
  legalComments: "none",
  logLevel: "warning",
});
