// The replay of a drive: a slider moves the robot on the map and a mark over the errors.
"use strict";
for (const box of document.querySelectorAll(".replay")) {
  const drive = JSON.parse(box.querySelector("script[type='application/json']").textContent);
  const [width, height] = drive.size_m;
  const slider = box.querySelector("input");
  const said = box.querySelector("output");
  const make = (parent, name, attributes) => {
    const element = document.createElementNS("http://www.w3.org/2000/svg", name);
    for (const [key, value] of Object.entries(attributes)) element.setAttribute(key, value);
    return parent.appendChild(element);
  };
  const line = (x, y) => x.map((value, k) => `${value.toFixed(3)},${y[k].toFixed(3)}`).join(" ");
  const style = (colour, wide) => `fill:none;stroke:${colour};stroke-width:${wide};stroke-linejoin:round`;

  const map = box.querySelector("svg.map");
  map.setAttribute("viewBox", `0 0 ${width} ${height}`);
  const up = make(map, "g", { transform: `matrix(1 0 0 -1 0 ${height})` });
  make(up, "rect", { width, height, style: "fill:none;stroke:var(--grid);stroke-width:.02" });
  for (const wall of drive.walls) {
    const points = wall.points_m.map((point) => point.join(",")).join(" ");
    make(up, "polyline", { points, style: style("var(--ink)", Math.max(wall.thickness_m, 0.03)) });
  }
  const robots = drive.tracks.map((track) => {
    make(up, "polyline", { points: line(track.x_m, track.y_m), style: style(track.colour, 0.015) + ";opacity:.6" });
    const group = make(up, "g", {});
    make(group, "circle", { r: 0.07, style: `fill:${track.colour};opacity:.85` });
    make(group, "line", { x1: 0, y1: 0, x2: 0.16, y2: 0, style: style(track.colour, 0.03) });
    return group;
  });

  const chart = box.querySelector("svg.errors");
  const end = drive.tracks[0].t_s.at(-1);
  const errors = drive.tracks.slice(1).map((track) => track.error_m);
  const most = Math.max(1e-4, ...errors.flat());
  chart.setAttribute("viewBox", "0 0 100 24");
  chart.setAttribute("preserveAspectRatio", "none");
  drive.tracks.slice(1).forEach((track) => {
    const points = line(track.t_s.map((t) => (100 * t) / end), track.error_m.map((e) => 23 - (22 * e) / most));
    make(chart, "polyline", { points, "vector-effect": "non-scaling-stroke", style: style(track.colour, 1.5) });
  });
  const mark = make(chart, "line", {
    y1: 0, y2: 24, "vector-effect": "non-scaling-stroke", style: style("var(--ink)", 1),
  });
  box.querySelector(".most").textContent = `${most.toPrecision(2)} m`;

  // The entry of a track at a time: the last one that is not later.
  const entry = (track, t) => {
    let low = 0;
    let high = track.t_s.length - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (track.t_s[middle] <= t) low = middle;
      else high = middle - 1;
    }
    return low;
  };
  const show = () => {
    const t = (end * slider.value) / slider.max;
    const texts = [`${t.toFixed(1)} s`];
    drive.tracks.forEach((track, number) => {
      const k = entry(track, t);
      const turn = (180 * track.heading_rad[k]) / Math.PI;
      robots[number].setAttribute("transform", `translate(${track.x_m[k]} ${track.y_m[k]}) rotate(${turn})`);
      if (number > 0) texts.push(`${track.name} ${track.error_m[k].toFixed(4)} m`);
    });
    mark.setAttribute("x1", (100 * t) / end);
    mark.setAttribute("x2", (100 * t) / end);
    said.textContent = texts.join(" \u00b7 ");
  };
  slider.addEventListener("input", show);
  // A link may name the moment: report.html#t=12.5
  const moment = () => {
    const named = location.hash.match(/^#t=([0-9.]+)$/);
    if (named) slider.value = Math.round((slider.max * Number(named[1])) / end);
    show();
  };
  addEventListener("hashchange", moment);
  moment();
}
