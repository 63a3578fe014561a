"""Maps over two parameters, and peaks along one."""
