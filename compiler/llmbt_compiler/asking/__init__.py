"""Asking back: what is asked, with its candidates, and what an answer settles without the model."""

from llmbt_compiler.asking.answer import Edit, choose, edit_for, edited
from llmbt_compiler.asking.question import Asked, Slot, from_diagnostics, from_model, from_request
from llmbt_compiler.asking.restated import restated

__all__ = [
    "Asked",
    "Edit",
    "Slot",
    "choose",
    "edit_for",
    "edited",
    "from_diagnostics",
    "from_model",
    "from_request",
    "restated",
]
