"""3D picture of one frame of a run, rendered by ParaView without a screen.

Particles are drawn as spheres, the mast by its own shape, the ground as a plane or by its heights. Half a computed
domain (mirror plane y = 0) is drawn whole. Needs Debian's paraview and python3-paraview.
"""
import os
import shutil
import subprocess
import sys

from mpmtools.errors import ConfigError, InputError
from mpmtools.figures.colours import colour_range
from mpmtools.files import require_ending, whole_file
from mpmtools.run import Run
from mpmtools.terrain import terrain_of

LABELS = {
    "stress_xx": ("stream-wise Cauchy stress (kPa)", 1e-3),
    "velocity": ("speed (m/s)", 1.0),
    "pressure": ("Cauchy pressure (kPa)", 1e-3),
    "density": ("density (kg/m3)", 1.0),
}


def polygons(paraview, corners, faces):
    """A surface. @param corners  (x, y, z), m. @param faces  each the numbers of its corners"""
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData

    points, cells, surface = vtkPoints(), vtkCellArray(), vtkPolyData()
    for corner in corners:
        points.InsertNextPoint(*corner)
    for face in faces:
        cells.InsertNextCell(len(face))
        for point in face:
            cells.InsertCellPoint(point)
    surface.SetPoints(points)
    surface.SetPolys(cells)
    source = paraview.TrivialProducer()
    source.GetClientSideObject().SetOutput(surface)
    return source


def prism(paraview, plan, foot, top):
    """A solid of this plan between two heights, m."""
    count = len(plan)
    sides = [(i, (i + 1) % count, count + (i + 1) % count, count + i) for i in range(count)]
    corners = [(x, y, z) for z in (foot, top) for x, y in plan]
    return polygons(paraview, corners, [tuple(range(count, 2 * count)), *sides])


def ground(paraview, terrain, low, high):
    """The uneven ground over a box in plan. @param low, high  corners (x, y), m"""
    x, y, height = terrain.mesh(low, high)
    first = [j * len(x) + i for j in range(len(y) - 1) for i in range(len(x) - 1)]
    return polygons(paraview, [(x[i], y[j], height[j, i]) for j in range(len(y)) for i in range(len(x))],
                    [(n, n + 1, n + 1 + len(x), n + len(x)) for n in first])


def picture_size(text):
    """(width, height) of WIDTHxHEIGHT, pixels."""
    try:
        width, height = (int(n) for n in text.split("x"))
    except ValueError:
        raise ConfigError(f"--size {text}: pixels are needed, such as 1600x1000") from None
    if not (16 <= width <= 8192 and 16 <= height <= 8192):
        raise ConfigError(f"--size {text}: from 16 to 8192 pixels are needed, such as 1600x1000")
    return width, height


def having(proxy, **properties):
    """Gives a proxy of ParaView these properties. Returns it."""
    for name, value in properties.items():
        setattr(proxy, name, value)
    return proxy


def render(options, paraview):
    """Builds the scene and writes the picture. Lengths in m."""
    run = Run(options.directory)
    mirrored = run.mirrored_y

    reader = paraview.OpenDataFile(os.path.join(options.directory, "frames.xdmf"))
    times = reader.TimestepValues
    times = [times] if isinstance(times, float) else list(times)
    if not times:
        raise InputError(f"{options.directory}: frames.xdmf holds no frame; let the run write one")
    time = times[-1] if options.time is None else min(times, key=lambda t: abs(t - options.time))
    reader.UpdatePipeline(time)

    label, factor = LABELS[options.field]
    source = "mag(velocity)" if options.field == "velocity" else options.field
    scaled = paraview.Calculator(Input=reader, Function=f"{factor}*{source}", ResultArrayName="shown")
    shown = [scaled]
    if mirrored:
        # The other half is drawn at (x, -y, z); only scalars are coloured, so that nothing else has to be turned.
        shown.append(paraview.Calculator(Input=scaled, Function="coordsX*iHat-coordsY*jHat+coordsZ*kHat", CoordinateResults=1,
                                         ResultArrayName="mirrored"))

    width, height = picture_size(options.size)
    view = having(paraview.CreateRenderView(), ViewSize=[width, height], ViewTime=time, OrientationAxesVisibility=0, UseColorPaletteForBackground=0,
                  BackgroundColorMode="Single Color", Background=[1.0, 1.0, 1.0])
    colours = paraview.GetColorTransferFunction("shown")
    set_colours(colours, reverse=options.field == "stress_xx")
    for source in shown:
        source.UpdatePipeline(time)
        display = paraview.Show(source, view)
        display.SetRepresentationType("Point Gaussian")
        having(display, GaussianRadius=0.5 * run.particle_spacing, ShaderPreset="Sphere")
        paraview.ColorBy(display, ("POINTS", "shown"))
    colours.RescaleTransferFunction(*colour_range(values_of(scaled), options.field))

    def show_plain(source, colour):
        having(paraview.Show(source, view), AmbientColor=colour, DiffuseColor=colour)

    bounds = list(scaled.GetDataInformation().GetBounds())
    south, north = (-bounds[3], bounds[3]) if mirrored else bounds[2:4]
    margin = 0.06 * (bounds[1] - bounds[0])
    west, east, south, north = bounds[0] - margin, bounds[1] + margin, south - margin, north + margin
    terrain = terrain_of(run)
    show_plain(ground(paraview, terrain, (west, south), (east, north)) if terrain
               else paraview.Plane(Origin=[west, south, -0.01], Point1=[east, south, -0.01], Point2=[west, north, -0.01]), [0.86, 0.86, 0.84])
    top = bounds[5]
    for corners, foot, head in run.solids(terrain.foot(run.obstacle_outline) if terrain and run.obstacle else 0.0, 1.15 * bounds[5]):
        top = max(top, head)
        show_plain(prism(paraview, corners, foot, head), [0.35, 0.37, 0.42])

    dark = [0.1, 0.1, 0.1]
    having(paraview.GetScalarBar(colours, view), Title=label, ComponentTitle="", TitleColor=dark, LabelColor=dark, TitleFontSize=20, LabelFontSize=18,
           AutomaticLabelFormat=0, LabelFormat="%.4g", RangeLabelFormat="%.4g", WindowLocation="Any Location", Position=[0.90, 0.22], ScalarBarLength=0.5,
           Orientation="Vertical", Visibility=1)
    text = paraview.Text(Text=f"{run.title}, t = {time:.2f} s")
    having(paraview.Show(text, view), Color=dark, FontSize=24, WindowLocation="Upper Center")

    # From upstream, above and beside the flow, so that the wetted front face is seen.
    bottom = min(0.0, bounds[4])
    x, y, z = 0.5 * (west + east), 0.5 * (south + north), bottom + 0.4 * (top - bottom)
    having(view, CameraFocalPoint=[x, y, z], CameraPosition=[x - 1.5, y - 1.2, z + 0.9], CameraViewUp=[0.0, 0.0, 1.0], CameraViewAngle=30)
    view.ResetCamera([west, east, south, north, bottom, top])  # keeps the direction, fits a sphere round the box
    paraview.GetActiveCamera().Zoom(1.1)
    output = options.out or os.path.join(options.directory, "post", "view_3d.png")
    require_ending(output, ".png")
    with whole_file(output) as temporary:
        paraview.SaveScreenshot(temporary, view, ImageResolution=[width, height])
        if not os.path.getsize(temporary):
            raise InputError(f"ParaView could not write '{output}'")
    print(output)


def set_colours(transfer_function, reverse):
    """Snow white for nothing, over blue and yellow to dark red for much; reversed where much is negative (compression)."""
    ramp = [(0.90, 0.94, 0.98), (0.42, 0.66, 0.88), (0.98, 0.82, 0.40), (0.89, 0.36, 0.20), (0.45, 0.04, 0.14)]
    if reverse:
        ramp.reverse()
    transfer_function.ColorSpace = "Lab"
    transfer_function.RGBPoints = [n for i, colour in enumerate(ramp) for n in (i / (len(ramp) - 1), *colour)]


def values_of(source):
    """The array 'shown'."""
    from paraview import servermanager
    from vtkmodules.util.numpy_support import vtk_to_numpy

    return vtk_to_numpy(servermanager.Fetch(source).GetPointData().GetArray("shown"))


def run_on_virtual_display():
    """Runs this command again on a virtual X server (package xvfb): Debian's ParaView draws with OpenGL on a display, and there is none.

    ParaView connects more than once; without -noreset the server restarts between two connections and may refuse the second.
    """
    if shutil.which("Xvfb") is None:
        raise InputError("no display, and Xvfb is missing; install Debian's xvfb")
    read_end, write_end = os.pipe()
    server = subprocess.Popen(["Xvfb", "-displayfd", str(write_end), "-screen", "0", "1600x1200x24", "-nolisten", "tcp", "-noreset"],
                              pass_fds=[write_end], stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    os.close(write_end)
    try:
        with os.fdopen(read_end) as ready:
            number = ready.readline().strip()
        if not number:
            raise InputError("the virtual display could not be started (Xvfb failed)")
        return subprocess.call([sys.executable, *sys.orig_argv[1:]], env={**os.environ, "DISPLAY": f":{number}"})
    finally:
        server.terminate()
        server.wait()


def run_command(options):
    picture_size(options.size)
    Run(options.directory).require_frames()
    if not os.path.exists(os.path.join(options.directory, "frames.xdmf")):
        raise InputError(f"{options.directory}: there is no frames.xdmf, which `mpm run` writes beside the frames")
    try:
        from paraview import simple
    except ImportError:
        raise InputError("ParaView for Python is missing; install Debian's paraview and python3-paraview") from None
    if "DISPLAY" not in os.environ:
        return run_on_virtual_display()
    simple._DisableFirstRenderCameraReset()
    render(options, simple)
    return 0
