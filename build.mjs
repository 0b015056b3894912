// Bundles the browser client: one entry per page, shared code in chunks, no source maps shipped.
import { build } from "esbuild";
import { readdir, rm } from "node:fs/promises";

const SOURCES = "web/static/js";
const OUTPUT = "web/static/dist";

const files = await readdir(SOURCES, { withFileTypes: true });
const entryPoints = files.filter((f) => f.isFile() && f.name.endsWith(".js")).map((f) => `${SOURCES}/${f.name}`);

await rm(OUTPUT, { recursive: true, force: true });
await build({
  entryPoints: [...entryPoints, "web/static/css/page.css", "web/static/css/play.css"],
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
