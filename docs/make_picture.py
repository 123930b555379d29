"""PNG of a fine surface coloured by normal stiffness, from the .vtu that `palpate export --format vtu` writes.

usage: xvfb-run -a pvpython docs/make_picture.py MODEL.vtu FIELD OUT.png [azimuth elevation]
Needs Debian's paraview and xvfb, for pictures in the documentation only.
"""
import sys
from paraview.servermanager import Fetch
from paraview.simple import (ColorBy, CreateView, GetColorTransferFunction, GetScalarBar, Render,
                             ResetCamera, SaveScreenshot, Show, XMLUnstructuredGridReader)
from vtkmodules.util.numpy_support import vtk_to_numpy

path, field, out = sys.argv[1:4]
azimuth, elevation = (float(a) for a in sys.argv[4:6]) if len(sys.argv) > 5 else (-30.0, 55.0)

reader = XMLUnstructuredGridReader(FileName=[path])
reader.UpdatePipeline()
values = [v for v in vtk_to_numpy(Fetch(reader).GetPointData().GetArray(field)) if v > 0]
low, high = min(values), max(values)  # the rest is not covered, or not pressed
view = CreateView("RenderView")
view.ViewSize = [1100, 760]
view.Background = [1, 1, 1]
view.UseColorPaletteForBackground = 0
view.OrientationAxesVisibility = 0
surface = Show(reader, view)
ColorBy(surface, ("POINTS", field))
colours = GetColorTransferFunction(field)
colours.ApplyPreset("Viridis (matplotlib)", True)
colours.RescaleTransferFunction(low, high)
bar = GetScalarBar(colours, view)
bar.Title, bar.ComponentTitle = field.replace("_", " "), ""
bar.TitleColor = bar.LabelColor = [0, 0, 0]
bar.Visibility = 1
surface.SetScalarBarVisibility(view, True)
surface.Specular = 0.3
ResetCamera(view)
view.CameraViewUp = [0, 0, 1]
camera = view.GetActiveCamera()
camera.SetPosition(camera.GetFocalPoint()[0], camera.GetFocalPoint()[1] - 1, camera.GetFocalPoint()[2])
camera.SetViewUp(0, 0, 1)
camera.Azimuth(azimuth)
camera.Elevation(elevation)
ResetCamera(view)
camera.Zoom(1.25)
Render(view)
SaveScreenshot(out, view)
