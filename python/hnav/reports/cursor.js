// The figures of a page share time. A range that is chosen in one is that of all, and all show the moment at which the pointer is: by a
// line, on a map by a dot on each track. `figures` are those of page.js; panels.py names in layout.meta the axes of time, and the maps.
const pointAt = time => document.dispatchEvent(new CustomEvent("point", { detail: time }));
const meta = div => div.layout.meta || {};
// Plotly leaves out axes without a trace.
const timeAxes = div => (meta(div).time || []).map(name => div._fullLayout[name]).filter(Boolean);

// The k-th element of a class over a figure, made when it is first needed.
function over(div, kind, k = 0) {
  const found = div.querySelectorAll(":scope > ." + kind);
  return found[k] || div.appendChild(Object.assign(document.createElement("div"), { className: kind }));
}
function place(element, left, top, style = {}) {
  Object.assign(element.style, { left: `${left}px`, top: `${top}px` }, style);
}

let moment = NaN;
function markTime(div) {
  // Axes one above the other have one line.
  const columns = [...new Map(timeAxes(div).map(axis => [axis._offset, axis])).values()];
  columns.forEach((axis, k) => {
    const x = axis.l2p(moment), size = div._fullLayout._size;
    place(over(div, "cursor", k), axis._offset + x, size.t, { height: `${size.h}px`, display: x >= 0 && x <= axis._length ? "" : "none" });
  });
}
function markPlaces(div) {
  const { xaxis, yaxis } = div._fullLayout;
  div._fullData.filter(trace => trace.customdata).forEach((trace, k) => {
    const row = trace.customdata.findIndex(time => time >= moment), x = xaxis.l2p(trace.x[row]), y = yaxis.l2p(trace.y[row]);
    const inside = x >= 0 && x <= xaxis._length && y >= 0 && y <= yaxis._length;
    place(over(div, "dot", k), xaxis._offset + x, yaxis._offset + y, { background: trace.line.color, display: inside ? "" : "none" });
  });
}
// A round number of metres, at the lower left, at most a quarter of the map.
function markScale(div) {
  const { xaxis, yaxis } = div._fullLayout, perPixel = xaxis.p2l(1) - xaxis.p2l(0);
  const most = Math.min(160, xaxis._length / 4) * perPixel, power = 10 ** Math.floor(Math.log10(most));
  const metres = power * [5, 2, 1].find(step => step * power <= most), bar = over(div, "bar");
  bar.dataset.length = metres < 1 ? `${Number((100 * metres).toPrecision(1))} cm` : metres < 1000 ? `${metres} m` : `${metres / 1000} km`;
  place(bar, xaxis._offset + 12, yaxis._offset + yaxis._length - 18, { width: `${metres / perPixel}px` });
}
const mark = div => (meta(div).map ? markPlaces(div) : markTime(div));

document.addEventListener("point", event => {
  moment = event.detail;
  figures.forEach(mark);
});

let isLinking = false;
async function link(div, changed) {
  if (isLinking || !Object.keys(changed).some(key => key.startsWith("xaxis"))) return;
  isLinking = true;
  const [{ range }] = timeAxes(div);
  const ranges = other => Object.fromEntries(timeAxes(other).map(axis => [`${axis._name}.range`, [...range]]));
  await Promise.all(figures.filter(other => other !== div && meta(other).time).map(other => Plotly.relayout(other, ranges(other))));
  isLinking = false;
}

for (const div of figures) {
  div.on("plotly_afterplot", () => {
    if (meta(div).map) markScale(div);
    mark(div);
  });
  if (meta(div).map) {
    markScale(div);
    div.on("plotly_hover", ({ points: [point] }) => point.customdata === undefined || pointAt(point.customdata));
  } else if (meta(div).time) {
    div.on("plotly_relayout", changed => link(div, changed));
    div.addEventListener("pointermove", event => {
      const x = event.clientX - div.getBoundingClientRect().left;
      const axis = timeAxes(div).find(one => x >= one._offset && x <= one._offset + one._length);
      if (axis) pointAt(axis.p2l(x - axis._offset));
    });
  }
}
