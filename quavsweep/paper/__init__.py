"""The paper, reproduced: its figures and tables from configs, what it prints against what is computed, a report."""

from quavsweep.paper.conductor import Reproduction, reproduce_paper

__all__ = ["Reproduction", "reproduce_paper"]
