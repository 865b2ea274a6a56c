# Filled in with the package test.
