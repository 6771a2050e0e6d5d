"""Proposals close to a posterior: mixtures, adapted to it by importance sampling."""
