"""`route.gpkg`, `route.geojson` and `events.csv`: what geographic information systems read."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyogrio
import shapely
from pyogrio.errors import DataLayerError, DataSourceError

from cable_tracker.arrays import FloatArray, interpolated
from cable_tracker.errors import one_line
from cable_tracker.metric.local_frame import LocalFrame
from cable_tracker.sequences.tables.csv_tables import write_csv
from cable_tracker.sequences.tables.estimates import format_stamp
from cable_tracker.survey.outputs.surveyed_dive import PICTURES, RECORDINGS
from cable_tracker.survey.routes.events import Event
from cable_tracker.survey.routes.merging import MergedRoute

EARTH = "EPSG:4326"
"""Longitude and latitude, WGS 84."""

LOCAL = 'LOCAL_CS["metres in the frame of odometry",UNIT["metre",1]]'

KILOMETRE_STEP = 0.1
"""Distance between two kilometre points [km]; short routes have finer ones."""

BAND_SIGMAS = 1.96
"""Half width of the band that holds the cable in 95 % [standard deviations]."""

MILLIMETRES, DEGREE_DIGITS = 3, 8

EVERY_METRE = "every_metre"
"""Layer of points with what is known of the cable there; a property of the route in GeoJSON."""

EVENT_COLUMNS = (
    "route", "kind", "kp_from_m", "kp_to_m", "length_m", "latitude", "longitude", "x_m", "y_m",
    "stamp", "recording", "frame", "picture", "detail",
)  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class SurveyMap:
    """Routes, and the frame they are in.

    Attributes
    ----------
    routes : tuple of MergedRoute
        Routes in metres.
    frame : LocalFrame or None
        Earth frame of the routes; None: frame of odometry.
    names : tuple of str
        One for each route.
    events_in_time : tuple of Event
        Events of recordings without metres.
    root : str
        Relative path from the folder of its files to that of the survey: "" or "../".
    folder : Path or None
        Folder of its files, beside which pictures of events lie; None: there are none.
    """

    routes: tuple[MergedRoute, ...]
    frame: LocalFrame | None
    names: tuple[str, ...]
    events_in_time: tuple[Event, ...] = ()
    root: str = ""
    folder: Path | None = None

    def coordinates(self, places: FloatArray) -> FloatArray:
        """Return the coordinates in files of places (N, 2) [m]: longitude, latitude, or x, y."""
        if self.frame is None:
            return np.round(places, MILLIMETRES)
        degrees = self.frame.to_degrees(places)[:, ::-1]
        # A line across 180 deg goes on beyond it: to the other side of the map it would be drawn
        # around the world.
        origin = self.frame.longitude
        degrees[:, 0] = origin + (degrees[:, 0] - origin + 180.0) % 360.0 - 180.0
        return np.round(degrees, DEGREE_DIGITS)

    @property
    def crs(self) -> str:
        """Coordinate reference system of the coordinates."""
        return LOCAL if self.frame is None else EARTH


def picture_name(survey: SurveyMap, event: Event) -> str:
    """Return where the picture of an event lies, from the folder of the map; empty without one."""
    if survey.folder is None or event.frame < 0:
        return ""
    name = f"{survey.root}{RECORDINGS}/{event.recording}/{PICTURES}/{event.frame}.jpg"
    return name if (survey.folder / name).is_file() else ""


def band(route: MergedRoute) -> FloatArray:
    """Return the outline of the band that holds the cable in 95 %, shape (2 N + 1, 2) [m].

    It runs counter-clockwise, as RFC 7946 asks of the outer ring of a polygon.
    """
    normal = np.column_stack((-np.sin(route.headings), np.cos(route.headings)))
    half = BAND_SIGMAS * route.sigmas[:, None]
    outline = np.concatenate((route.places - half * normal, (route.places + half * normal)[::-1]))
    return np.concatenate((outline, outline[:1]))


def kilometre_points(route: MergedRoute) -> tuple[FloatArray, FloatArray]:
    """Return arc lengths along a route (K,) [m] and the places there (K, 2) [m]."""
    step = 1000.0 * KILOMETRE_STEP
    while route.along[-1] < 5 * step and step > 10.0:
        step /= 10.0
    along = np.arange(0.0, route.along[-1] + 1e-6, step)
    places = interpolated(along, route.along, route.places)
    return along, places


def at_every_metre(route: MergedRoute) -> dict[str, FloatArray]:
    """Return the columns of a route at every metre of its length."""
    along = np.arange(0.0, np.floor(route.along[-1]) + 1.0)
    columns = {
        "x_m": route.places[:, 0],
        "y_m": route.places[:, 1],
        "heading_rad": route.headings,
        "sigma_m": route.sigmas,
        "visible": route.visible,
        "diameter_m": route.diameters,
        "vehicle_beside_m": route.asides,
        "dives": route.dives,
    }
    found = {name: np.interp(along, route.along, values) for name, values in columns.items()}
    # Dives are counted, not measured.
    found["dives"] = np.rint(found["dives"])
    return {"kp_m": along, **found}


def _event_row(survey: SurveyMap, name: str, event: Event) -> list[object]:
    """Return a line of `events.csv`; None where there is no number, "" where there is no text."""
    latitude = longitude = None
    if survey.frame is not None and np.isfinite(event.place).all():
        degrees = survey.frame.to_degrees(np.array([event.place]))[0]
        latitude, longitude = (round(float(value), DEGREE_DIGITS) for value in degrees)

    def metres(value: float) -> float | None:
        return round(value, MILLIMETRES) if np.isfinite(value) else None

    return [
        name, event.kind.value, metres(event.along), metres(event.end),
        metres(event.end - event.along), latitude, longitude, *map(metres, event.place),
        format_stamp(event.stamp) if event.stamp else "", event.recordings,
        event.frame if event.frame >= 0 else None, picture_name(survey, event), event.detail,
    ]  # fmt: skip


def event_rows(survey: SurveyMap) -> list[list[object]]:
    """Return the lines of `events.csv`, columns `EVENT_COLUMNS`."""
    rows = [
        _event_row(survey, name, event)
        for name, route in zip(survey.names, survey.routes, strict=True)
        for event in route.events
    ]
    return rows + [_event_row(survey, "", event) for event in survey.events_in_time]


def write_events(path: Path, survey: SurveyMap) -> None:
    """Write `events.csv`."""
    write_csv(path, EVENT_COLUMNS, event_rows(survey))


@dataclass(frozen=True, slots=True, eq=False)
class _Layer:
    """Shapes of one kind, with a column for each of their attributes."""

    name: str
    kind: str
    shapes: Sequence[Any]
    columns: dict[str, list[Any]]


def _layers(survey: SurveyMap) -> list[_Layer]:
    """Return the layers of a map: its routes first, one shape each."""
    routes = list(zip(survey.names, survey.routes, strict=True))
    names = {"name": [name for name, _ in routes]}
    lines = [shapely.LineString(survey.coordinates(route.places)) for _, route in routes]
    bands = [shapely.Polygon(survey.coordinates(band(route))) for _, route in routes]
    placed = [(name, event) for name, route in routes for event in route.events]
    points = [shapely.Point(survey.coordinates(np.array([event.place]))[0]) for _, event in placed]
    table = [_event_row(survey, name, event) for name, event in placed]
    of_route: dict[str, list[Any]] = {
        "length_m": [float(route.along[-1]) for _, route in routes],
        "sigma_median_m": [float(np.median(route.sigmas)) for _, route in routes],
        "recordings": [", ".join(route.recordings) for _, route in routes],
    }
    of_events = {column: [row[k] for row in table] for k, column in enumerate(EVENT_COLUMNS)}
    return [
        _Layer("route", "LineString", lines, names | of_route),
        _Layer("band_95", "Polygon", bands, names),
        _metre_layer(survey, routes),
        _kp_layer(survey, routes),
        _Layer("events", "Point", points, of_events),
    ]


def _metre_layer(survey: SurveyMap, routes: Sequence[tuple[str, MergedRoute]]) -> _Layer:
    points: list[Any] = []
    columns: dict[str, list[Any]] = {}
    for name, route in routes:
        table = at_every_metre(route)
        places = survey.coordinates(np.column_stack((table.pop("x_m"), table.pop("y_m"))))
        points += list(shapely.points(places))
        columns.setdefault("name", []).extend([name] * len(places))
        for key, values in table.items():
            columns.setdefault(key, []).extend(values.tolist())
    return _Layer(EVERY_METRE, "Point", points, columns)


def _kp_layer(survey: SurveyMap, routes: Sequence[tuple[str, MergedRoute]]) -> _Layer:
    points: list[Any] = []
    columns: dict[str, list[Any]] = {"name": [], "kp_m": [], "label": []}
    for name, route in routes:
        along, places = kilometre_points(route)
        points += list(shapely.points(survey.coordinates(places)))
        columns["name"] += [name] * len(along)
        columns["kp_m"] += along.tolist()
        columns["label"] += [f"KP {metres_along / 1000:.3f}" for metres_along in along]
    return _Layer("kp", "Point", points, columns)


def write_geojson(path: Path, survey: SurveyMap) -> None:
    """Write the layers as features, one a line; every metre is a property of its route."""
    features: list[dict[str, Any]] = []
    for layer in _layers(survey):
        if layer.name == EVERY_METRE:
            continue
        for number, shape in enumerate(layer.shapes):
            own = {column: values[number] for column, values in layer.columns.items()}
            if layer.name == "route":
                table = at_every_metre(survey.routes[number])
                own["length_m"] = round(own["length_m"], MILLIMETRES)
                own["sigma_median_m"] = round(own["sigma_median_m"], 4)
                own[EVERY_METRE] = {key: rounded(values, 4) for key, values in table.items()}
            properties = {"layer": layer.name, **own}
            geometry = shapely.geometry.mapping(shape)
            features.append({"type": "Feature", "geometry": geometry, "properties": properties})
    content: dict[str, Any] = {"type": "FeatureCollection", "name": "cable"}
    if survey.frame is None:
        # RFC 7946 knows WGS 84 only: what is written is said in a member of our own.
        content["coordinates"] = "metres in the frame of odometry, not on the earth"
    with path.open("w", encoding="utf-8") as file:
        file.write(json.dumps(content)[:-1] + ', "features": [\n')
        file.write(",\n".join(json.dumps(feature) for feature in features))
        file.write("\n]}\n")


def rounded(values: FloatArray, digits: int) -> list[float | None]:
    """Return values (N,) as JSON has them: to so many digits, and None for what is no number."""
    return [round(float(value), digits) if np.isfinite(value) else None for value in values]


def write_geopackage(path: Path, survey: SurveyMap) -> None:
    """Write the layers that hold anything."""
    path.unlink(missing_ok=True)
    for layer in _layers(survey):
        if layer.shapes:
            _add_layer(path, layer, survey.crs)


def _add_layer(path: Path, layer: _Layer, crs: str) -> None:
    try:
        pyogrio.raw.write(
            str(path),
            geometry=shapely.to_wkb(np.array(layer.shapes, dtype=object)),
            field_data=[_column(values) for values in layer.columns.values()],
            fields=np.array(list(layer.columns), dtype=object),
            geometry_type=layer.kind,
            crs=crs,
            layer=layer.name,
            driver="GPKG",
            append=path.exists(),
        )
    # A full disk is one of these too.
    except (DataSourceError, DataLayerError) as error:
        raise OSError(one_line(error)) from error


def _column(values: list[Any]) -> Any:  # noqa: ANN401  Of any type that a column may have.
    # NaN is written as a value that is missing.
    if all(value is None or isinstance(value, (int, float)) for value in values):
        return np.array(values, np.float64)
    return np.array([str(value) for value in values], dtype=object)


Writer = Callable[[Path, SurveyMap], None]
WRITERS: dict[str, Writer] = {
    "route.gpkg": write_geopackage,
    "route.geojson": write_geojson,
    "events.csv": write_events,
}
"""Files of a survey that hold routes or events."""
