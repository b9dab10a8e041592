"""What every room stands on: checks of arguments, colour, progress of passes, files that appear whole."""
