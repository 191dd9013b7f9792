#!/usr/bin/python3
"""judge.py EVIDENCE JUDGE.onnx: learns from the files of terrazzo_evidence how much a region overlaps a particle.

Four small networks with different first weights; their mean is steadier than one of them.
"""
import sys

import numpy as np
import torch
from torch import nn

EVIDENCE, HIDDEN, NETWORKS, PASSES, RATE, BATCH = 14, 24, 4, 6, 1e-2, 4096


class Judge(nn.Module):
    """Maps evidence (n, 14) to the expected overlap (n, 1)."""

    def __init__(self, mean, deviation):
        super().__init__()
        self.mean, self.deviation = mean, deviation
        self.networks = nn.ModuleList(
            nn.Sequential(nn.Linear(EVIDENCE, HIDDEN), nn.ReLU(), nn.Linear(HIDDEN, HIDDEN), nn.ReLU(), nn.Linear(HIDDEN, 1))
            for _ in range(NETWORKS))

    def normalize(self, x):
        return (x - self.mean) / self.deviation

    def forward(self, x):
        return torch.sigmoid(sum(network(x) for network in self.networks) / NETWORKS)

    def fold(self):
        """Moves the normalization into the first layers."""
        with torch.no_grad():
            for network in self.networks:
                first = network[0]
                first.weight /= self.deviation
                first.bias -= first.weight @ self.mean


def main():
    torch.manual_seed(1)
    torch.set_num_threads(1)
    rows = np.fromfile(sys.argv[1], np.float32).reshape(-1, EVIDENCE + 2)
    if len(rows) == 0 or not np.isfinite(rows).all():
        raise SystemExit(f"judge: {sys.argv[1]} holds no rows, or values that are not finite")
    held_back = rows[:, -1] % 10 == 9
    x, y = torch.from_numpy(rows[:, :EVIDENCE].copy()), torch.from_numpy(rows[:, EVIDENCE].copy())
    judge = Judge(x.mean(0), x.std(0) + 1e-6)
    x = judge.normalize(x)
    known_x, known_y = x[~held_back], y[~held_back]
    steps = PASSES * -(-len(known_x) // BATCH)
    for network in judge.networks:
        optimizer, step = torch.optim.Adam(network.parameters(), lr=RATE, weight_decay=1e-5), 0
        for _ in range(PASSES):
            order = torch.randperm(len(known_x))
            for k in range(0, len(order), BATCH):
                for group in optimizer.param_groups:
                    group["lr"] = RATE * (1 - step / steps) + 1e-5
                i = order[k:k + BATCH]
                optimizer.zero_grad()
                nn.functional.binary_cross_entropy_with_logits(network(known_x[i])[:, 0], known_y[i]).backward()
                optimizer.step()
                step += 1
    with torch.no_grad():
        expected, true = judge(x[held_back])[:, 0].numpy(), y[held_back].numpy()
    print(f"{len(rows)} regions; held back: correlation {np.corrcoef(expected, true)[0, 1]:.3f}, "
          f"root mean square error {np.sqrt(np.mean((expected - true) ** 2)):.3f}")
    judge.fold()
    torch.onnx.export(judge, torch.zeros(4, EVIDENCE), sys.argv[2], opset_version=11, input_names=["evidence"],
                      output_names=["overlap"], dynamic_axes={"evidence": {0: "n"}, "overlap": {0: "n"}})


if __name__ == "__main__":
    main()
