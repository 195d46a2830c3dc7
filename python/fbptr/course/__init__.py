"""Frameworks of courses, with the package's memory beneath: a student's own code draws into it unchanged.

`fbptr.course.gpu` has the interface of the simulated GPU of "Renderizador" (Insper); `python -m
fbptr.course.renderizador` runs a student's folder with it. Both need numpy.
"""
