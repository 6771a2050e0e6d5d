"""Chains: sampled by emcee, stopped by rule, diagnosed."""
