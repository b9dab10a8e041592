"""The solvers: radiosity, meshless radiosity, form factors, reference path tracing."""
