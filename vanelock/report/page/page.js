// Curves by plotly.js with the page's own legend, which a keyboard reaches and which wraps on a
// phone; and what printing needs: plots and tables at the paper's width.
(() => {
  "use strict";
  const PAPER = 680;  // pixels across an A4 page inside its margins
  const touch = matchMedia("(pointer: coarse)").matches;
  const plots = [...document.querySelectorAll("figure.plot")];

  function draw(figure) {
    const area = figure.querySelector(".area");
    if (area.dataset.drawn) return;
    area.dataset.drawn = "yes";
    const { data, layout } = JSON.parse(figure.querySelector("script").textContent);
    const buttons = ["toImage", "zoom2d", "pan2d", "zoomIn2d", "zoomOut2d", "resetScale2d"];
    const options = {
      responsive: true,
      displaylogo: false,
      displayModeBar: touch ? true : "hover",
      modeBarButtons: [buttons],
      toImageButtonOptions: { filename: figure.id, scale: 2 },
    };
    if (touch) {  // a finger scrolls the page; the buttons zoom
      layout.dragmode = false;
      layout.margin.t = 36;
    }
    Plotly.newPlot(area, data, layout, options);
    const entries = [...figure.querySelectorAll(".legend button")];
    const traces = (entry) => JSON.parse(entry.dataset.traces);
    const show = (entry, on) => {
      entry.setAttribute("aria-pressed", on);
      return Plotly.restyle(area, { visible: on }, traces(entry));
    };
    const shown = (entry) => entry.getAttribute("aria-pressed") === "true";
    const isolate = (entry) => {  // that one alone, or all again
      const alone = entries.every((other) => shown(other) === (other === entry));
      for (const other of entries) show(other, alone || other === entry);
    };
    for (const entry of entries) {
      entry.addEventListener("click", (event) =>
        event.shiftKey ? isolate(entry) : show(entry, !shown(entry)));
      entry.addEventListener("dblclick", (event) => event.shiftKey || isolate(entry));
    }
  }

  // One after the other, so that the page can be read meanwhile.
  function drawNext(left) {
    if (!left.length) return;
    draw(left[0]);
    setTimeout(drawNext, 0, left.slice(1));
  }
  drawNext(plots);

  // The keyboard stops at tables that need scrolling, and at no others.
  const reach = () => {
    for (const box of document.querySelectorAll(".scroll")) {
      box.tabIndex = box.scrollWidth > box.clientWidth ? 0 : -1;
    }
  };
  reach();
  window.addEventListener("resize", reach);

  for (const frame of document.querySelectorAll(".picture .frame")) {
    frame.addEventListener("click", () => {  // between the column's width and the picture's own
      frame.setAttribute("aria-pressed", frame.getAttribute("aria-pressed") === "false");
    });
  }

  window.addEventListener("beforeprint", () => {
    for (const figure of plots) {
      draw(figure);
      const area = figure.querySelector(".area");
      Plotly.relayout(area, { width: PAPER, height: 320 });
    }
    document.documentElement.classList.add("printing");
    for (const folded of document.querySelectorAll("details:not([open])")) {
      folded.open = true;
      folded.dataset.opened = "";
    }
    for (const table of document.querySelectorAll(".scroll table")) {
      const share = PAPER / table.scrollWidth;
      if (share < 1) table.style.fontSize = `${12 * share}px`;
    }
  });
  window.addEventListener("afterprint", () => {
    document.documentElement.classList.remove("printing");
    for (const opened of document.querySelectorAll("details[data-opened]")) {
      opened.open = false;
      delete opened.dataset.opened;
    }
    for (const figure of plots) {
      Plotly.relayout(figure.querySelector(".area"), { width: null, height: null, autosize: true });
    }
    for (const table of document.querySelectorAll(".scroll table")) table.style.fontSize = "";
  });
})();
