"""What solvers give: values, the field anywhere, pictures, files."""
