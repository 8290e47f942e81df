import base64
import csv
import json
from dataclasses import replace

import numpy as np
import pyogrio
import pytest
import shapely

from cable_tracker.metric.local_frame import LocalFrame
from cable_tracker.survey.outputs.maps import (
    WRITERS,
    SurveyMap,
    band,
    picture_name,
    write_events,
    write_geopackage,
)
from cable_tracker.survey.outputs.report import RecordingRow, write_report
from cable_tracker.survey.routes.events import Event, EventKind


def test_gdal_reads_all_layers_of_the_geopackage(written, survey):
    layers = dict(pyogrio.list_layers(written / "route.gpkg"))
    assert layers == {
        "route": "LineString", "band_95": "Polygon", "every_metre": "Point", "kp": "Point",
        "events": "Point",
    }  # fmt: skip
    info = pyogrio.read_info(written / "route.gpkg", layer="every_metre")
    assert info["crs"] == "EPSG:4326"
    assert info["features"] == int(survey.routes[0].along[-1]) + 1


def test_every_metre_has_a_standard_deviation(written):
    _, _, _, columns = pyogrio.raw.read(
        written / "route.gpkg", layer="every_metre", columns=["kp_m", "sigma_m"]
    )
    assert np.diff(columns[0]) == pytest.approx(1.0)
    assert (columns[1] > 0.0).all()


def test_the_route_lies_where_the_datum_is(written):
    box = pyogrio.read_info(written / "route.gpkg", layer="route", force_total_bounds=True)
    west, south, _, _ = box["total_bounds"]
    assert (south, west) == pytest.approx((54.25, 7.9), abs=1e-3)


def test_gdal_reads_the_geojson(written):
    info = pyogrio.read_info(written / "route.geojson")
    features = json.loads((written / "route.geojson").read_text())["features"]
    assert info["features"] == len(features)
    layers = {feature["properties"]["layer"] for feature in features}
    assert layers == {"route", "band_95", "kp", "events"}


def test_events_are_a_table_with_places_and_pictures(written):
    rows = list(csv.DictReader((written / "events.csv").read_text().splitlines()))
    (buried,) = [row for row in rows if row["kind"] == "buried or overgrown"]
    assert float(buried["length_m"]) == pytest.approx(6.0, abs=0.6)
    assert float(buried["latitude"]) == pytest.approx(54.25, abs=1e-3)
    assert buried["picture"] == ""


def test_the_picture_of_a_dive_with_a_comma_in_its_name_is_found(tmp_path):
    event = Event(EventKind.BEND, 1.0, 2.0, (0.0, 0.0), 5, 7, "", "dive, part 2", ("dive, part 1",))
    name = "recordings/dive, part 2/pictures/7.jpg"
    survey = SurveyMap((), None, (), folder=tmp_path)
    assert picture_name(survey, event) == ""
    (tmp_path / name).parent.mkdir(parents=True)
    (tmp_path / name).write_bytes(b"a picture")
    assert picture_name(survey, event) == name
    assert event.recordings == "dive, part 2, dive, part 1"


def test_the_band_runs_counter_clockwise(survey):
    assert shapely.is_ccw(shapely.LinearRing(band(survey.routes[0])))


def test_an_event_without_a_frame_leaves_numbers_numbers(survey, tmp_path):
    (route,) = survey.routes
    apart = Event(EventKind.DISAGREEMENT, 1.0, 4.0, (1.0, 0.0), 0, -1, "apart", "dive", ("other",))
    both = replace(survey, routes=(replace(route, events=(*route.events, apart)),))
    for name, write in WRITERS.items():
        write(tmp_path / name, both)
    for name in ("route.gpkg", "route.geojson"):
        layer = "events" if name == "route.gpkg" else None
        info = pyogrio.read_info(tmp_path / name, layer=layer)
        kinds = dict(zip(info["fields"], info["dtypes"], strict=True))
        assert kinds["frame"] in ("float64", "int32", "int64"), name
        assert kinds["kp_from_m"] == kinds["latitude"] == "float64"
    _, _, _, (kinds, frames) = pyogrio.raw.read(
        tmp_path / "route.gpkg", layer="events", columns=["kind", "frame"]
    )
    assert (np.isnan(frames) == (kinds == "dives disagree")).all()
    rows = list(csv.DictReader((tmp_path / "events.csv").read_text().splitlines()))
    (row,) = [row for row in rows if row["kind"] == "dives disagree"]
    assert row["frame"] == row["stamp"] == "" and row["recording"] == "dive, other"
    write_report(tmp_path / "report.html", both, [], "survey")
    assert "None" not in (tmp_path / "report.html").read_text()


def test_a_map_in_a_folder_of_its_own_finds_the_pictures(survey, tmp_path):
    beside = tmp_path / "without_place"
    beside.mkdir()
    (buried,) = [each for each in survey.routes[0].events if each.kind is EventKind.BURIED]
    picture = tmp_path / f"recordings/dive/pictures/{buried.frame}.jpg"
    picture.parent.mkdir(parents=True)
    picture.write_bytes(b"a picture")
    apart = replace(survey, root="../", folder=beside)
    write_events(beside / "events.csv", apart)
    rows = list(csv.DictReader((beside / "events.csv").read_text().splitlines()))
    (name,) = {row["picture"] for row in rows if row["kind"] == "buried or overgrown"}
    assert (beside / name).resolve() == picture
    write_report(beside / "report.html", apart, [], "survey")
    assert base64.b64encode(b"a picture").decode() in (beside / "report.html").read_text()


def test_without_a_place_on_the_earth_there_are_metres(survey, tmp_path):
    local = SurveyMap(survey.routes, None, survey.names)
    for name, write in WRITERS.items():
        write(tmp_path / name, local)
    assert "EPSG" not in str(pyogrio.read_info(tmp_path / "route.gpkg", layer="route")["crs"])
    assert "not on the earth" in (tmp_path / "route.geojson").read_text()


def test_a_survey_without_routes_writes_its_tables_all_the_same(tmp_path):
    nothing = SurveyMap((), None, ())
    write_events(tmp_path / "events.csv", nothing)
    write_report(tmp_path / "report.html", nothing, [RecordingRow("a", "failed: no frames")], "x")
    assert "failed: no frames" in (tmp_path / "report.html").read_text()


def test_a_geopackage_that_cannot_be_written_is_an_error_of_the_system(survey, tmp_path):
    with pytest.raises(OSError):
        write_geopackage(tmp_path / "no folder" / "route.gpkg", survey)


def test_a_cable_across_the_antimeridian_is_drawn_in_one_stroke(survey, tmp_path):
    west = replace(survey, frame=LocalFrame(-17.0, 179.9999))
    WRITERS["route.gpkg"](tmp_path / "route.gpkg", west)
    box = pyogrio.read_info(tmp_path / "route.gpkg", layer="route", force_total_bounds=True)
    assert box["total_bounds"][2] - box["total_bounds"][0] < 0.01
