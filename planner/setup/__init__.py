"""From a request to configurations: named, joint, position and pose targets become configurations."""
