// The figures of a page in the colours and sizes of the screen (screen.js).
const touch = matchMedia("(pointer: coarse)").matches;

// Everything that is a size in pixels, in the measure of the page's letters.
function enlarge(layout, data, by) {
  layout.height *= by;
  layout.font.size *= by;
  for (const side of ["l", "r", "t", "b"]) layout.margin[side] *= by;
  layout.legend.font.size *= by;
  for (const note of layout.annotations || []) note.font.size *= by;
  for (const trace of data) {
    if (trace.line && trace.line.width) trace.line.width *= by;
    if (trace.marker && typeof trace.marker.size === "number") trace.marker.size *= by;
  }
}

function draw(div) {
  const spec = JSON.parse(onScreen(document.getElementById("data-" + div.id).textContent));
  if (touch) spec.layout.dragmode = false; // a finger moves the page
  enlarge(spec.layout, spec.data, scale());
  return Plotly.react(div, spec.data, spec.layout, spec.config);
}
const figures = [...document.querySelectorAll(".plotly-graph-div")];
const drawAll = () => figures.forEach(draw);
drawAll();
dark.addEventListener("change", drawAll);
