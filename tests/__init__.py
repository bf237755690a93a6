"""Tests: closed forms, identities and naive twins first; invariances to the bit."""
