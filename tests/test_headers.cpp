// Nothing: this file's target compiles the headers that the tests share.
