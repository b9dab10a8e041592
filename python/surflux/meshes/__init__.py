"""Meshes of files and of other libraries, with their colours, materials and textures; their patches and winding."""
