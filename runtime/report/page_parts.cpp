#include "runtime/report/page_parts.h"

namespace overcast {

const char* const kPageHead = R"(<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>Overcast: error against time</title>
<style>
:root { --ink: #1d2733; --quiet: #56636f; --line: #dde3e9; --ground: #f6f8fa; --accent: #005f8a; }
* { box-sizing: border-box; }
body { margin: 0; background: var(--ground); color: var(--ink); font: 15px/1.5 system-ui, "DejaVu Sans", sans-serif; }
main { max-width: 1320px; margin: 0 auto; padding: 28px 24px 60px; }
h1 { font-size: 26px; margin: 0 0 4px; } h2 { font-size: 20px; margin: 48px 0 10px; } h3 { font-size: 15px; margin: 0 0 6px; }
p { margin: 6px 0; max-width: 110ch; } .quiet { color: var(--quiet); font-size: 13px; } a { color: var(--accent); }
nav { margin: 12px 0 0; display: flex; flex-wrap: wrap; gap: 4px 14px; }
.panel { background: #fff; border: 1px solid var(--line); border-radius: 8px; padding: 14px 16px; margin: 12px 0; overflow-x: auto; }
.pair { display: grid; grid-template-columns: repeat(auto-fit, minmax(480px, 1fr)); gap: 14px; margin: 12px 0; } .pair .panel { margin: 0; }
.chart { width: 100%; height: auto; display: block; } .chart text { font-size: 11px; fill: var(--quiet); }
.chart .axis { font-size: 12px; fill: var(--ink); } .grid { stroke: var(--line); fill: none; }
.chart .name { fill: var(--ink); font-size: 10.5px; }
.front { stroke: #76828d; stroke-width: 1.5; stroke-dasharray: 5 4; fill: none; }
.series { fill: none; stroke-width: 1.2; stroke-opacity: .45; }
.mark { cursor: pointer; outline: none; } .mark > :first-child { fill-opacity: .85; stroke-width: 1.4; }
.mark:hover > :first-child, .mark:focus > :first-child, .mark.chosen > :first-child { stroke: #000; stroke-width: 3; fill-opacity: 1; }
.legend { display: flex; flex-wrap: wrap; gap: 4px 18px; font-size: 13px; align-items: center; }
.legend svg { width: 16px; height: 16px; vertical-align: -3px; margin-right: 4px; }
table { border-collapse: collapse; width: 100%; font-size: 13px; font-variant-numeric: tabular-nums; }
th, td { padding: 4px 8px; border-bottom: 1px solid var(--line); text-align: right; white-space: nowrap; }
th { color: var(--quiet); font-weight: 600; cursor: pointer; } th:first-child, td:first-child { text-align: left; }
tr:hover td { background: #eef4f8; } tr.chosen td { background: #dcebf5; } tr[data-row] { cursor: pointer; }
.front-row td:first-child { font-weight: 600; }
details { margin: 10px 0; } details summary { cursor: pointer; color: var(--accent); font-size: 14px; }
.viewer { display: grid; grid-template-columns: repeat(3, minmax(0, 1fr)); gap: 12px; }
figure { margin: 0; } figure img, figure canvas { width: 100%; display: block; border: 1px solid var(--line); image-rendering: pixelated; }
figcaption { font-size: 12px; color: var(--quiet); margin-top: 3px; }
.chosen-text { white-space: pre-line; font-size: 13px; min-height: 6.2em; margin: 0 0 8px; }
.scale { height: 10px; margin-top: 4px; background: linear-gradient(90deg, #0d38b8, #fff 50%, #c70d14); border: 1px solid var(--line); }
ul { margin: 6px 0; padding-left: 20px; } li { margin: 3px 0; }
</style></head><body><main>
)";

const char* const kPageScript = R"(<script>
"use strict";
const linear = (code) => { const x = code / 255; return x <= 0.04045 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4; };
const load = (uri) => new Promise((done) => { const image = new Image(); image.onload = () => done(image); image.src = uri; });
const pixels = (image) => {
  const canvas = document.createElement("canvas");
  canvas.width = image.naturalWidth; canvas.height = image.naturalHeight;
  const context = canvas.getContext("2d");
  context.drawImage(image, 0, 0);
  return context.getImageData(0, 0, canvas.width, canvas.height);
};
// White where both agree, red where the picture is too bright, blue where it is too dark; what shows no surface keeps its blue grey.
const drawDifference = (canvas, picture, reference) => {
  const a = pixels(picture), b = pixels(reference), full = { up: [199, 13, 20], down: [13, 56, 184] };
  canvas.width = a.width; canvas.height = a.height;
  const made = new ImageData(a.width, a.height);
  for (let i = 0; i < a.data.length; i += 4) {
    made.data[i + 3] = 255;
    const surface = b.data[i] === b.data[i + 2];
    const error = surface ? (linear(a.data[i]) - linear(b.data[i])) / overcastRange : 0;
    const t = Math.min(Math.abs(error), 1), colour = error > 0 ? full.up : full.down;
    for (let c = 0; c < 3; ++c) made.data[i + c] = surface ? 255 + t * (colour[c] - 255) : b.data[i + c];
  }
  canvas.getContext("2d").putImageData(made, 0, 0);
};
document.querySelectorAll("section[data-scene]").forEach((section) => {
  const uris = overcastPictures[section.dataset.scene], text = section.querySelector(".chosen-text");
  const image = section.querySelector(".viewer img"), canvas = section.querySelector(".viewer canvas");
  const select = section.querySelector("select"), marks = section.querySelectorAll("[data-row]");
  const reference = load(uris[0]);
  let shown = "", pinned = select.value;
  const show = async (row) => {
    if (row === shown) return;
    shown = row; select.value = row;
    marks.forEach((mark) => mark.classList.toggle("chosen", mark.dataset.row === row));
    const title = section.querySelector(`.mark[data-row="${row}"] title`);
    text.textContent = title ? title.textContent : "";
    const picture = await load(uris[Number(row) + 1]);
    if (shown !== row) return;
    image.src = picture.src;
    drawDifference(canvas, picture, await reference);
  };
  const pin = (row) => { pinned = row; show(row); };
  marks.forEach((mark) => {
    mark.addEventListener("mouseenter", () => show(mark.dataset.row));
    mark.addEventListener("mouseleave", () => show(pinned));
    mark.addEventListener("click", () => pin(mark.dataset.row));
    mark.addEventListener("keydown", (event) => { if (event.key === "Enter") pin(mark.dataset.row); });
  });
  select.addEventListener("change", () => pin(select.value));
  show(pinned);
});
document.querySelectorAll("table.sorted").forEach((table) => table.querySelectorAll("th").forEach((head, column) => {
  let down = false;
  head.addEventListener("click", () => {
    down = !down;
    const body = table.tBodies[0], value = (row) => row.cells[column].textContent;
    const order = (a, b) => (column === 0 ? value(a).localeCompare(value(b)) : (parseFloat(value(a)) || 0) - (parseFloat(value(b)) || 0));
    [...body.rows].sort((a, b) => (down ? order(a, b) : order(b, a))).forEach((row) => body.append(row));
  });
}));
</script>
)";

}  // namespace overcast
