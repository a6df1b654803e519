#pragma once
// Pictures and HTML pages of a result folder, drawn by scripts/report.py in a child process. The numbers are on disk
// before: whatever goes wrong here (no Python, no jinja2, a crash) is a warning on stderr and never a failed run.
#include <string>

namespace kt {

struct ReportSettings {
  std::string title = {};  ///< empty: the scene's
  std::string python = "/usr/bin/python3";
  std::string figures = {};  ///< svg or pdf: force and mesh in this format, too
  double seconds = 60.0;     ///< the script takes 2 s; a stuck one ends after this
};

/// force.png, mesh.png and report.html in `dir`; with `figures` the two pictures as vectors, too.     @returns whether
/// all of them were made
bool write_report(const std::string& dir, const ReportSettings& settings = {});

/// paper.png and paper.html in `dir`, from its folders slide, stick, stick_slip and coulomb.
bool write_paper_report(const std::string& dir, const ReportSettings& settings = {});

/// chart.html, and for each chart a .png and an .svg, in `dir`, from its chart.json.
bool write_chart_report(const std::string& dir);
/// <map>.png, <map>.svg and stability.html in `dir`, from stability.json and the maps' tables.
bool write_stability_report(const std::string& dir, const ReportSettings& settings = {.seconds = 300.0});
/// report.html in `dir`, from its report.json and outlines.json (`kilotouch check`).
bool write_check_page(const std::string& dir);
/// compare.html in `dir`, from its compare.json and the traces of the runs that it names.
bool write_compare_page(const std::string& dir);

}  // namespace kt
