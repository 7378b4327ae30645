G0 X0 (a ! ~ ? in a comment)
G1 X1 !
