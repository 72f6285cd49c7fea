"""DXF files, by ezdxf."""
