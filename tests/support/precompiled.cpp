// Nothing: the target is there for the headers that the tests share.
