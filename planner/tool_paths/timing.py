def timed_on_path(*a):
    return None
