// Builds dist/ from src/: one script, one style sheet, one HTML file.
// An argument is the directory for them, instead of dist/.
import { build } from "esbuild";
import { copyFile, mkdir } from "node:fs/promises";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const here = dirname(fileURLToPath(import.meta.url));
const out = process.argv[2] ?? join(here, "dist");
await mkdir(out, { recursive: true });
await build({
  absWorkingDir: here,
  entryPoints: ["src/main.tsx"],
  bundle: true,
  format: "esm",
  target: "es2022",
  jsx: "automatic",
  jsxImportSource: "preact",
  minifySyntax: true,
  minifyWhitespace: true,
  banner: { js: "// With preact and @preact/signals, MIT licence: see THIRD-PARTY.txt beside the sources of this page." },
  charset: "utf8",
  lineLimit: 160,
  outfile: join(out, "page.js"),
}).catch(() => process.exit(1));
await build({ absWorkingDir: here, entryPoints: ["src/page.css"], outfile: join(out, "page.css"), minify: true, lineLimit: 160 });
await copyFile(join(here, "src/index.html"), join(out, "index.html"));
