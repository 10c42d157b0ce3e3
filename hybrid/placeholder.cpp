namespace relief {}
