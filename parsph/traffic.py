"""What ranks tell each other in a step, and how evenly they share the work."""

from statistics import fmean

from .progress import size_text


def traffic(simulation, steps):
    """Return what was sent in `steps` steps, and the imbalance; collective.

    Returns
    -------
    dict
        "communication", each per step: "messages" and "bytes" that a rank sends to its neighbours, "mean" and of the rank
        with the "largest", and "collectives", calls of each. "imbalance": largest over mean cost of the ranks, "mean" over
        the run and "largest"; None before the cuts were looked at.
    """
    comm, exchange, imbalance, steps = simulation.communicator, simulation.domain.exchange, simulation.imbalance, max(steps, 1)
    collectives = {name: calls / steps for name, calls in sorted(comm.collectives.items())}
    messages, sent = zip(*comm.allgather((exchange.messages / steps, exchange.bytes / steps)), strict=True)
    told = {"messages": _mean_and_largest(messages), "bytes": _mean_and_largest(sent), "collectives": collectives}
    shares = {"mean": imbalance.mean, "largest": imbalance.largest} if imbalance.count else None
    return {"communication": told, "imbalance": shares}


def _mean_and_largest(values):
    return {"mean": fmean(values), "largest": max(values)}


def traffic_text(summary):
    """Return one line that says what `traffic` has found."""
    told, imbalance = summary["communication"], summary["imbalance"]
    messages, sent = told["messages"], told["bytes"]
    parts = [
        f"per step and rank {messages['mean']:.1f} messages, {size_text(sent['mean'])} "
        f"(largest {messages['largest']:.1f}, {size_text(sent['largest'])})",
        ", ".join(f"{calls:.2f} {name}" for name, calls in told["collectives"].items()),
    ]
    parts += [f"imbalance {imbalance['mean']:.3f} (largest {imbalance['largest']:.3f})"] if imbalance else []
    return "; ".join(parts)
