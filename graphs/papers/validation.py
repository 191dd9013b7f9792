"""validation.py OUT FIGURE.svg: prints and draws how far the results of validation.yaml in OUT are from published values."""
import csv
import json
import sys

import matplotlib
import numpy as np

matplotlib.use("svg")
import matplotlib.pyplot as plt  # noqa: E402

OUT = sys.argv[1]
PLANES = 20  # of `cut`


def columns(name, *wanted):
    with open(f"{OUT}/{name}.csv") as file:
        rows = list(csv.DictReader(file))
    return [np.array([float(r[c]) for r in rows]) for c in wanted]


def equal_spheres(axes):
    """Wicksell 1925: a share 1 − √(1 − d²/D²) of a sphere's sections is smaller than d."""
    d, weight = columns("equal", "equivalent_diameter", "weight")
    order = np.argsort(d)
    d, share = d[order], np.cumsum(weight[order]) / weight.sum()
    exact = 1 - np.sqrt(np.clip(1 - d ** 2, 0, 1))
    count = int((weight > 0).sum())
    print(f"equal spheres: largest difference {abs(share - exact).max():.4f}, 95 % of samples have less than {1.36 / count ** 0.5:.4f}")
    axes.plot(d, exact, "k-", lw=1, label="Wicksell 1925")
    axes.plot(d, share, "C1--", label=f"{count:,} profiles")
    axes.set(xlabel="profile diameter / sphere diameter", ylabel="share below", title="Sections of equal spheres")


def saltykov(profiles_per_area, width):
    """Number per volume by class for spheres at the upper ends of equal classes, from the largest down (Saltykov 1958)."""
    n = len(profiles_per_area)
    seen = lambda sphere, j: width * (np.sqrt((sphere + 1.0) ** 2 - j ** 2) - np.sqrt((sphere + 1.0) ** 2 - (j + 1) ** 2))
    out = np.zeros(n)
    for j in reversed(range(n)):
        out[j] = (profiles_per_area[j] - sum(out[i] * seen(i, j) for i in range(j + 1, n))) / seen(j, j)
    return out


def lognormal_spheres(axes):
    low, high, found, least, most = columns("unfolded", "size_low", "size_high", "N_V", "low", "high")
    edges = np.append(low, high[-1])
    with open(f"{OUT}/report.json") as file:
        box = next(n["metrics"]["box_x"] for n in json.load(file)["nodes"] if n["name"] == "box")
    true = np.histogram(columns("truth", "size")[0], edges)[0] / box ** 3
    d, weight = columns("lognormal", "equivalent_diameter", "weight")
    classic = saltykov(np.histogram(d, edges, weights=weight)[0] / (PLANES * box ** 2), high[0] - low[0])
    error = lambda values: abs(values - true).sum() / true.sum()
    print(f"lognormal spheres: L1 error of Unfold {error(found):.3f}, of Schwartz-Saltykov {error(classic):.3f}")
    axes.stairs(true, edges, color="k", label="spheres in the box")
    axes.errorbar((low + high) / 2, found, [found - least, most - found], fmt="C1o", capsize=2, label="Unfold, 90 %")
    axes.plot(high, classic, "C0x", label="Schwartz–Saltykov")
    axes.set(xlabel="diameter, mm", ylabel="number per mm³ and class", title="Unfolded lognormal spheres", ylim=(-0.01, 0.18))


def grains(axes):
    """Neper's grain growth: 1 − sphericity is lognormal with mean 0.145 and standard deviation 0.03."""
    sphericity = columns("grains", "sphericity")[0]
    print(f"grains: sphericity {sphericity.mean():.3f} ± {sphericity.std():.3f}; grain growth has 0.855 ± 0.03")
    x = np.linspace(0.65, 0.999, 400)
    sd = np.sqrt(np.log(1 + (0.03 / 0.145) ** 2))
    density = np.exp(-((np.log((1 - x) / 0.145) + sd ** 2 / 2) / sd) ** 2 / 2) / ((1 - x) * sd * np.sqrt(2 * np.pi))
    axes.hist(sphericity, 40, density=True, color="C1", alpha=0.6, label="Tessellate")
    axes.plot(x, density, "k-", lw=1, label="grain growth")
    axes.set(xlabel="sphericity", ylabel="density", title="Polycrystal", xlim=(0.65, 1))


plt.rcParams.update({"svg.hashsalt": "terrazzo", "font.size": 9})
figure, panels = plt.subplots(1, 3, figsize=(11, 3.4))
for draw, panel in zip([equal_spheres, lognormal_spheres, grains], panels):
    draw(panel)
    panel.legend(frameon=False, loc="upper left" if draw is not lognormal_spheres else "upper right")
figure.tight_layout()
figure.savefig(sys.argv[2], metadata={"Date": None})
