// Nothing: the target is there for the headers that the layers above the core share.
