"""What the trainings of both convolutional networks share: the rate, the running mean of the weights, and the precision."""
import pathlib

import torch


def rate_at(step, steps, rate):
    """Rises for 100 steps, stays for half of all, then falls linearly to a hundredth."""
    done = step / steps
    return rate * min(1, (step + 1) / 100) * (1 if done < 0.5 else max(0.01, 2 * (1 - done)))


def update_mean(average, network, step):
    """Moves the running mean of the weights, which is steadier than the last step's, towards those after `step` steps."""
    keep = min(0.995, step / (step + 20))
    with torch.no_grad():
        for mean, now in zip(average.state_dict().values(), network.state_dict().values()):
            if mean.dtype.is_floating_point:
                mean.mul_(keep).add_(now, alpha=1 - keep)
            else:
                mean.copy_(now)


def save_checkpoint(path, state):
    """Replaces the file only when the new one is complete."""
    torch.save(state, path.with_suffix(".new"))
    path.with_suffix(".new").replace(path)


def multiplies_bfloat16():
    """Whether the processor has instructions for bfloat16, with which a step takes a third of the time."""
    flags = pathlib.Path("/proc/cpuinfo").read_text(errors="replace")
    return "avx512_bf16" in flags or "amx_bf16" in flags
