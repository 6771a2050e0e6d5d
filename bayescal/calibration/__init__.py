"""Many views of a target: fits and evidence of lens models, the poses integrated out."""
