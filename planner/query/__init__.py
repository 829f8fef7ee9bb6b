"""What is asked, made concrete: named, joint, position and pose targets become configurations."""
