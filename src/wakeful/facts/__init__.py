"""The words of wakeful as frozen values, and the one table of process transitions."""
