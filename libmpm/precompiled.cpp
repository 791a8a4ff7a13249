// Empty: the target exists for the precompiled headers of the layers above the core.
