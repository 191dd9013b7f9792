"""What the trainings of both convolutional networks share: options, the steps, the running mean of the weights, the checkpoint
and the precision."""
import pathlib
import signal

import torch


def parsed(p, steps, batch, rate):
    """The arguments with those that both trainings have, which take effect."""
    p.add_argument("--steps", type=int, default=steps)
    p.add_argument("--batch", type=int, default=batch)
    p.add_argument("--rate", type=float, default=rate)
    p.add_argument("--seed", type=int, default=1)
    p.add_argument("--threads", type=int, default=2)
    a = p.parse_args()
    torch.set_num_threads(a.threads)
    torch.manual_seed(a.seed)
    a.work.mkdir(parents=True, exist_ok=True)
    return a


def interrupts():
    """A list that is empty until the process is to end."""
    stop = []
    signal.signal(signal.SIGINT, lambda *_: stop.append(1))
    signal.signal(signal.SIGTERM, lambda *_: stop.append(1))
    return stop


def rate_at(step, done, rate):
    """Rises for 100 steps, stays for half of the training, of which `done` is the share so far, then falls linearly to a hundredth."""
    return rate * min(1, (step + 1) / 100) * (1 if done < 0.5 else max(0.01, 2 * (1 - done)))


def update_mean(average, network, step, most=0.995):
    """Moves the running mean of the weights, which is steadier than the last step's, towards those after `step` steps. It covers
    a twentieth of all steps so far, and at most 1 / (1 - most) steps."""
    keep = min(most, step / (step + 20))
    means, now = values_of(average), values_of(network)
    with torch.no_grad():
        torch._foreach_mul_(means, keep)  # all of them at once: a GPU takes as long for one
        torch._foreach_add_(means, now, alpha=1 - keep)


def values_of(network):
    """What a network has learned: its weights, and the statistics of the normalization."""
    return [v.detach() for v in (*network.parameters(), *network.buffers()) if v.dtype.is_floating_point]


def descend(network, optimizer, loss, rate):
    """One step against the gradient of the loss."""
    for group in optimizer.param_groups:
        group["lr"] = rate
    optimizer.zero_grad(set_to_none=True)
    loss.backward()
    torch.nn.utils.clip_grad_norm_(network.parameters(), 5.0)
    optimizer.step()


def save(state, path):
    """Replaces the file only when the new one is complete."""
    torch.save(state, path.with_suffix(".new"))
    path.with_suffix(".new").replace(path)


def save_checkpoint(path, network, average, optimizer, step, seconds):
    save({"network": network.state_dict(), "average": average.state_dict(), "optimizer": optimizer.state_dict(), "step": step,
          "seconds": seconds}, path)


def load_checkpoint(path, network, average, optimizer):
    """The step and the seconds of training of a checkpoint, whose state the others take."""
    state = torch.load(path, map_location="cpu")
    network.load_state_dict(state["network"])
    average.load_state_dict(state["average"])
    optimizer.load_state_dict(state["optimizer"])
    return state["step"], state["seconds"]


def multiplies_bfloat16():
    """Whether the processor has instructions for bfloat16, with which a step takes a third of the time."""
    flags = pathlib.Path("/proc/cpuinfo").read_text(errors="replace")
    return "avx512_bf16" in flags or "amx_bf16" in flags
