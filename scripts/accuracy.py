#!/usr/bin/python3
"""Tables and pictures of docs/accuracy_and_speed.md from what scripts/accuracy measured: DIR/fem.json, DIR/scene-nu-model/,
DIR/scene-material/.

    scripts/accuracy.py DIR docs/pictures
"""
import math
import os
import sys

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt  # noqa: E402

from measured import read_csv, read_json  # noqa: E402

COLOURS = {"tet4": "#d55e00", "tet10": "#0072b2"}
plt.rcParams.update({"font.size": 11, "axes.spines.top": False, "axes.spines.right": False, "axes.titleweight": "bold",
                     "axes.titlelocation": "left", "figure.dpi": 110})


def rows_of(rows, **wanted):
    return [row for row in rows if all(row[key] == value for key, value in wanted.items())]


def reference(rows, poisson):
    """Richardson's extrapolation of the three finest quadratic meshes (cells 3, 4, 6: not one ratio, so by a search for
    the order p that puts u + c h^p through all three)."""
    (h1, u1), (h2, u2), (h3, u3) = [(1 / r["cells"], r["tip"]) for r in rows_of(rows, element="tet10", poisson=poisson)[-3:]]
    low, high = 0.3, 6.0
    for _ in range(80):
        p = 0.5 * (low + high)
        ratio = (h1**p - h2**p) / (h2**p - h3**p)
        low, high = (p, high) if ratio < (u1 - u2) / (u2 - u3) else (low, p)
    c = (u2 - u3) / (h2**p - h3**p)
    return u3 - c * h3**p, p


def cantilever(rows, folder):
    poissons = sorted({row["poisson"] for row in rows})
    print("| ν | reference tip [mm] | order, tet4 | order, tet10 | locking, tet4 | locking, tet10 |\n|---|---|---|---|---|---|")
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.3))
    for poisson in poissons:
        exact, _ = reference(rows, poisson)
        line = []
        for element in ("tet4", "tet10"):
            chosen = rows_of(rows, element=element, poisson=poisson)
            errors = [abs(row["tip"] / exact - 1) for row in chosen]
            order = math.log(errors[-2] / errors[-1]) / math.log(chosen[-1]["cells"] / chosen[-2]["cells"])
            line.append((order, exact / chosen[-1]["tip"]))
            if poisson in (0.3, 0.499):
                left.loglog([row["nodes"] for row in chosen], errors, "o-" if poisson == 0.3 else "s--", color=COLOURS[element],
                            label=f"{element}, ν = {poisson:g}")
        print(f"| {poisson:g} | {1e3 * exact:.5f} | {line[0][0]:.2f} | {line[1][0]:.2f} | {line[0][1]:.3f} | {line[1][1]:.3f} |")
        for element in ("tet4", "tet10"):
            finest = rows_of(rows, element=element, poisson=poisson)[-1]
            right.plot(poissons.index(poisson), exact / finest["tip"], "o", color=COLOURS[element],
                       label=f"{element}, {finest['nodes']} nodes" if poisson == poissons[0] else None)
    left.set(xlabel="nodes", ylabel="error of the tip's deflection", title="Cantilever: convergence")
    left.legend(frameon=False)
    right.axhline(1.05, color="0.6", linewidth=1)
    right.text(0, 1.07, "1.05", color="0.4")
    right.set(xticks=range(len(poissons)), xticklabels=[f"{p:g}" for p in poissons], xlabel="Poisson's ratio",
              ylabel="too stiff by the factor", title="Locking at 8281 nodes", yscale="log")
    right.set_yticks([1, 1.5, 2, 3], ["1", "1.5", "2", "3"])
    right.minorticks_off()
    right.legend(frameon=False)
    figure.tight_layout()
    figure.savefig(os.path.join(folder, "fem_cantilever.png"))


def hertz(data, folder):
    print("\n| element | nodes | finest cell / contact radius | force / Hertz | s | point tool [N/m] |\n|---|---|---|---|---|---|")
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.3))
    for element in ("tet4", "tet10"):
        rows = rows_of(data["rows"], element=element)
        for row in rows:
            print(f"| {element} | {row['nodes']} | {row['finest'] / data['contact_radius']:.2f} | {1 + row['off']:.3f} | "
                  f"{row['seconds']:.1f} | {row['point_stiffness']:.1f} |")
        h = [row["finest"] / data["contact_radius"] for row in rows]
        left.semilogx(h, [1 + row["off"] for row in rows], "o-", color=COLOURS[element], label=element)
        right.loglog(h, [row["point_stiffness"] for row in rows], "o-", color=COLOURS[element], label=element)
    left.axhspan(0.95, 1.05, color="0.9", zorder=0)
    left.axhline(1, color="0.5", linewidth=1)
    left.set(ylabel="force / Hertz", title="Sphere: converges to Hertz (band: 5 %)")
    right.set(ylabel="stiffness under one node [N/m]", title="Point tool: does not converge")
    for panel in (left, right):
        panel.set_xlabel("finest cell / contact radius")
        panel.invert_xaxis()
        panel.set_xticks([0.75, 0.5, 0.25], ["0.75", "0.5", "0.25"])
        panel.minorticks_off()
        panel.legend(frameon=False)
    right.set_yticks([5, 10, 20], ["5", "10", "20"])
    figure.tight_layout()
    figure.savefig(os.path.join(folder, "fem_hertz.png"))


def recovery(rows, folder):
    print("\n| material | start | elements inside out, before and after | off after 0.2 s | after 4 s |\n|---|---|---|---|---|")
    figure, panels = plt.subplots(1, 2, figsize=(11, 4.0), sharey=True)
    colours = {"neo_hookean": "#0072b2", "corotational": "#009e73", "stvk": "#d55e00"}
    for row in rows:
        print(f"| {row['material']} | {row['start']} | {row['inverted']}, {row['still_inverted']} | {row['off'][10]:.2g} | {row['off'][-1]:.1g} |")
        panel = panels[int(row["start"] == "scrambled")]
        panel.semilogy([0.02 * i for i in range(len(row["off"]))], [max(1e-15, off) for off in row["off"]],
                       color=colours[row["material"]], label=row["material"])
    panels[0].set(title="Crushed to 5 % of its height", ylabel="farthest node / edge of the block")
    panels[1].set(title="Nodes thrown about at random")
    for panel in panels:
        panel.set_xlabel("time [s]")
        panel.legend(frameon=False)
    figure.tight_layout()
    figure.savefig(os.path.join(folder, "fem_recovery.png"))


def normal_force(run):
    return [float(row["f_n"]) for row in read_csv(os.path.join(run, "trace.csv"))]


def springs(folder):
    print("\n| scene | ν | springs, mean [N] | finite elements, mean [N] | force error |\n|---|---|---|---|---|")
    for scene in ("slab_drag", "organ_springs"):
        for poisson in ("0.3", "0.25"):
            spring, element = (normal_force(os.path.join(folder, f"{scene}-{poisson}-{model}")) for model in ("msd", "fem"))
            error = math.sqrt(sum((a - b) ** 2 for a, b in zip(spring, element)) / sum(b * b for b in element))
            means = [sum(force) / max(1, sum(f > 0 for f in force)) for force in (spring, element)]
            print(f"| {scene} | {poisson} | {means[0]:.3f} | {means[1]:.3f} | {100 * error:.0f} % |")


def scenes(folder):
    print("\n| scene | material | F_N, mean [N] | largest F_T / (μ F_N) | missed | lost | deepest [µm] | inside out |\n"
          "|---|---|---|---|---|---|---|---|")
    for scene in ("slab_drag", "organ_springs", "paper_slide", "paper_stick", "paper_stick_slip"):
        for material in ("linear", "corotational", "stvk", "neo_hookean"):
            run = read_json(os.path.join(folder, f"{scene}-{material}", "summary.json"))
            ratio = run["force"]["max_t_over_mu_n"]
            inverted = [warning.split()[0] for warning in run["warnings"] if "inside out" in warning]
            print(f"| {scene} | {material} | {run['force']['mean_n']:.3f} | {'-' if ratio is None else f'{ratio:.3g}'} | "
                  f"{run['missed_impacts']} | {run['lost_contacts']} | {1e6 * run['penetration_max_m']:.2g} | "
                  f"{inverted[0] if inverted else 0} of {run['model']['tets']} |")


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    data = read_json(os.path.join(sys.argv[1], "fem.json"))
    cantilever(data["cantilever"], sys.argv[2])
    hertz(data["hertz"], sys.argv[2])
    recovery(data["recovery"], sys.argv[2])
    springs(sys.argv[1])
    scenes(sys.argv[1])


if __name__ == "__main__":
    main()
