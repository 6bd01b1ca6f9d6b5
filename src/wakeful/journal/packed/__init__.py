"""How entries are written in few bytes: words by number, fields by place, and a schema that says which places they are."""
