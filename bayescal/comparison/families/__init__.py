"""Families of joint models of r and c: built, sampled or weighed, and judged."""
