"""Texts that say where points are: such as files have, and such as make a library open what they name."""

SPHEROID = 'SPHEROID["GRS 1980",6378137,298.257222101]'
TAIL = 'PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]'
GEOGRAPHIC = f'GEOGCS["g",DATUM["d",{SPHEROID}],{TAIL}]'
MERCATOR = ('PROJECTION["Mercator_1SP"],PARAMETER["central_meridian",0],PARAMETER["scale_factor",1],'
            'PARAMETER["false_easting",0],PARAMETER["false_northing",0],UNIT["metre",1]')
VERTICAL = 'VERT_CS["NAVD88 height",VERT_DATUM["North American Vertical Datum 1988",2005{}],UNIT["metre",1]{}]'


def projected(more="", name="p", tail=MERCATOR):
    return f'PROJCS["{name}",{GEOGRAPHIC},{tail}{more}]'


def bound(file, quoted=True, word="PARAMETERFILE"):
    name = f'"{file}"' if quoted else file
    base = ('GEODCRS["g",DATUM["d",ELLIPSOID["GRS 1980",6378137,298.257222101,LENGTHUNIT["metre",1]]],'
            'CS[ellipsoidal,2],AXIS["lat",north],AXIS["lon",east],ANGLEUNIT["degree",0.0174532925199433]]')
    target = base.replace('"g"', '"WGS 84"').replace('"d"', '"World Geodetic System 1984"')
    return (f'BOUNDCRS[SOURCECRS[{base}],TARGETCRS[{target}],ABRIDGEDTRANSFORMATION["t",'
            f'METHOD["NTv2",ID["EPSG",9615]],{word}["Latitude and longitude difference file",{name}]]]')


def derived(method, parameter="", value=0):
    more = f',PARAMETER["{parameter}",{value}]' if parameter else ""
    return (f'PROJCRS["p",BASEGEOGCRS["g",DATUM["d",ELLIPSOID["GRS 1980",6378137,298.257222101]]],'
            f'CONVERSION["c",METHOD["{method}"]{more}],CS[Cartesian,2],AXIS["x",east],AXIS["y",north],'
            'LENGTHUNIT["metre",1]]')


# As surveys, ESRI's and GDAL's programs write them; the grids are none of PROJ's own, or may be.
TAKEN = {
    "code": "EPSG:2154",
    "compound code": "EPSG:5698",
    "WKT 1": projected(name="NAD83 / UTM zone 17N"),
    "in small letters, with blanks and round brackets": projected().lower().replace("[", " (").replace("]", ")"),
    "with authority": projected(',AUTHORITY["EPSG","3395"]'),
    "with another authority": projected(',AUTHORITY["SR-ORG","7483"]'),
    "web Mercator of GDAL": projected(',EXTENSION["PROJ4","+proj=merc +a=6378137 +b=6378137 +lat_ts=0 +lon_0=0 +x_0=0 '
                                      '+y_0=0 +k=1 +units=m +nadgrids=@null +wktext +no_defs"]'),
    "heights by a geoid": f'COMPD_CS["NAD83 / UTM zone 17N + NAVD88 height - Geoid12B (metre)",{projected()},'
                          + VERTICAL.format(',EXTENSION["PROJ4_GRIDS","g2012bu0.gtx"],AUTHORITY["EPSG","5103"]', '') + "]",
    "ESRI's, one behind the other": projected() + ',VERTCS["NAVD_1988",VDATUM["North_American_Vertical_Datum_1988"],'
                                    'PARAMETER["Vertical_Shift",0.0],PARAMETER["Direction",1.0],UNIT["Meter",1.0]]',
    "NTv2 by name": bound("ntf_r93.gsb"),
    "WKT 2": 'PROJCRS["WGS 84 / UTM zone 31N",BASEGEOGCRS["WGS 84",ENSEMBLE["World Geodetic System 1984 ensemble",'
             'MEMBER["World Geodetic System 1984 (Transit)"],ELLIPSOID["WGS 84",6378137,298.257223563,'
             'LENGTHUNIT["metre",1]],ENSEMBLEACCURACY[2.0]],PRIMEM["Greenwich",0,ANGLEUNIT["degree",0.0174532925199433]]],'
             'CONVERSION["UTM zone 31N",METHOD["Transverse Mercator",ID["EPSG",9807]],'
             'PARAMETER["Latitude of natural origin",0,ANGLEUNIT["degree",0.0174532925199433],ID["EPSG",8801]],'
             'PARAMETER["Longitude of natural origin",3,ANGLEUNIT["degree",0.0174532925199433]],'
             'PARAMETER["Scale factor at natural origin",0.9996,SCALEUNIT["unity",1]],'
             'PARAMETER["False easting",500000,LENGTHUNIT["metre",1]],PARAMETER["False northing",0,LENGTHUNIT["metre",1]]],'
             'CS[Cartesian,2],AXIS["(E)",east,ORDER[1]],AXIS["(N)",north,ORDER[2]],LENGTHUNIT["metre",1],'
             'USAGE[SCOPE["Engineering survey / mapping."],AREA["Between 0\u00b0E and 6\u00b0E, \u201cnorth\u201d."],'
             'BBOX[0,0,84,6]],ID["EPSG",32631,URI["http://www.opengis.net/def/crs/EPSG/0/32631"]],REMARK["see ""a/b"""]]',
    "local": 'LOCAL_CS["site grid A/B",UNIT["metre",1]]',
}


def refused(file):
    """What names `file`, or could, by every way that PROJ 9.1.1 and GDAL 3.6.2 have; or is no WKT that may be read."""
    grids = f'EXTENSION["PROJ4_GRIDS","{file}"]'
    said = f"+proj=longlat +ellps=GRS80 +nadgrids={file} +no_defs"
    return {
        "no keyword, +init": f"a[ +init={file}:foo",
        "no keyword, a path": f"x[/../..{file}",
        "a keyword, +init": f"PROJCS[ +init={file}:foo",
        "a keyword, +init behind WKT": projected() + f" +init={file}:foo",
        "a PROJ string": said,
        "a PROJ string with +geoidgrids": f"+proj=longlat +ellps=GRS80 +geoidgrids={file}",
        "+init": f"+init={file}:foo",
        "a path": file,
        "a URL": f"http://127.0.0.1:9{file}",
        "a URN": f"urn:ogc:def:crs:{file}::1",
        "ESRI's prefix": f"ESRI::{projected(',' + grids)}",
        "a prefix of a dictionary": f"DICT:{file},1",
        "PROJJSON": '{"type":"GeographicCRS","name":"g","datum":{"type":"GeodeticReferenceFrame","name":"%s"}}' % file,
        "an authority that is no number": f"EPSG:{file}",
        "two codes": "EPSG:2154+5720",
        "grids of a datum": f'GEOGCS["g",DATUM["d",{SPHEROID},{grids}],{TAIL}]',
        "grids of a datum, not quoted": f'GEOGCS["g",DATUM["d",{SPHEROID},EXTENSION[PROJ4_GRIDS,{file}]],{TAIL}]',
        "grids, with printed quotation marks": f'GEOGCS["g",DATUM["d",{SPHEROID},EXTENSION["PROJ4_GRIDS",\u201c{file}\u201d]],{TAIL}]',
        "grids, which may be missing": f'GEOGCS["g",DATUM["d",{SPHEROID},EXTENSION["PROJ4_GRIDS","@null,@{file}"]],{TAIL}]',
        "grids, in small letters": f'geogcs["g",datum["d",{SPHEROID},extension["proj4_grids","{file}"]],{TAIL}]',
        "grids, from here": f'GEOGCS["g",DATUM["d",{SPHEROID},EXTENSION["PROJ4_GRIDS","./{file}"]],{TAIL}]',
        "grids, from home": f'GEOGCS["g",DATUM["d",{SPHEROID},EXTENSION["PROJ4_GRIDS","~{file}"]],{TAIL}]',
        "grids from an address": f'GEOGCS["g",DATUM["d",{SPHEROID},EXTENSION["PROJ4_GRIDS","http://127.0.0.1:9{file}"]],{TAIL}]',
        "grids of a system": f'GEOGCS["g",DATUM["d",{SPHEROID}],{TAIL},{grids}]',
        "grids of a projected system's datum": f'PROJCS["p",GEOGCS["g",DATUM["d",{SPHEROID},{grids}],{TAIL}],{MERCATOR}]',
        "grids of heights": f'COMPD_CS["c",{projected()},' + VERTICAL.format("," + grids, "") + "]",
        "a PROJ string in a projected system": projected(f',EXTENSION["PROJ4","+proj=merc +nadgrids={file} +no_defs"]'),
        "a PROJ string in a projection of PROJ's": projected(
            f',EXTENSION["PROJ4","+proj=bonne +lat_1=10 +nadgrids={file}"]', tail='PROJECTION["custom_proj4"],UNIT["metre",1]'),
        "a PROJ string with +init": projected(f',EXTENSION["PROJ4","+proj=merc +init={file}:foo"]'),
        "a PROJ string with a pole": projected(f',EXTENSION["PROJ4","+proj=ob_tran +o_proj=longlat +o_lon_p=0 +o_lat_p=30 +nadgrids={file}"]'),
        "a PROJ string in a geographic system": f'GEOGCS["g",DATUM["d",{SPHEROID}],{TAIL},EXTENSION["PROJ4","{said}"]]',
        "a PROJ string in a remark": projected().replace("PROJCS", "PROJCS")[:-1] + f',REMARK["PROJ CRS string: {said}"]]',
        "a PROJ string in a remark of WKT 2": derived("Mercator (variant A)")[:-1] + f',REMARK["PROJ CRS string: {said}"]]',
        "a file of a transformation": bound(file),
        "a file of a transformation, not quoted": bound(file, quoted=False),
        "a method of PROJ's": derived(f"PROJ-based operation method: +proj=hgridshift +grids={file}"),
        "a method of PROJ's with more": derived(f"PROJ merc +nadgrids={file}"),
        "a parameter of PROJ's with more": derived("PROJ merc", f"lat_1=1 +nadgrids={file} +x", 1),
        "a model of the geoid": 'COMPOUNDCRS["c",' + derived("Mercator (variant A)") + ',VERTCRS["v",VDATUM["d"],CS[vertical,1],'
                                f'AXIS["up",up],LENGTHUNIT["metre",1],GEOIDMODEL["PROJ {file}"]]]',
        "an authority with +init": projected(f',AUTHORITY["a[ +init={file}","foo"]'),
        "an authority that is a path": projected(f',AUTHORITY["{file}","x"]'),
        "an id that is a path": derived("Mercator (variant A)")[:-1] + f',ID["{file}",1]]',
        "a name that is a PROJ string": projected(name=f"p +init={file}:foo "),
        "a datum that is a PROJ string": f'GEOGCS["g",DATUM["d using nadgrids={file}",{SPHEROID}],{TAIL}]',
        "too deep": "GEOGCS[" * 40 + '"x"' + "]" * 40,
        "not closed": projected()[:-1],
        "not closed, quoted": 'PROJCS["p',
        "too long": f'PROJCS["{"x" * 70000}"]',
    }


def inert(file):
    """Taken, since nothing opens what stands there; `file` names nothing."""
    return {
        "a name": projected(name=f"p {file}"),
        "a datum": f'GEOGCS["g",DATUM["{file}",{SPHEROID}],{TAIL}]',
        "an ellipsoid": f'GEOGCS["g",DATUM["d",SPHEROID["{file}",6378137,298.257222101]],{TAIL}]',
        "a meridian": f'GEOGCS["g",DATUM["d",{SPHEROID}],PRIMEM["{file}",0],UNIT["degree",0.0174532925199433]]',
        "a unit": f'GEOGCS["g",DATUM["d",{SPHEROID}],PRIMEM["Greenwich",0],UNIT["{file}",0.0174532925199433]]',
        "heights": f'COMPD_CS["{file}",{projected()},VERT_CS["{file}",VERT_DATUM["{file}",2005],UNIT["metre",1]]]',
        "a remark": derived("Mercator (variant A)")[:-1] + f',REMARK["{file}"]]',
    }


def by_name(name):
    """What names a file without its folder: PROJ looks for it in its own folders, and nobody elsewhere."""
    return {
        "grids of a datum, by name": f'GEOGCS["g",DATUM["d",{SPHEROID},EXTENSION["PROJ4_GRIDS","{name}"]],{TAIL}]',
        "heights by name": f'COMPD_CS["c",{projected()},' + VERTICAL.format(f',EXTENSION["PROJ4_GRIDS","{name}"]', "") + "]",
        "a PROJ string, by name": projected(f',EXTENSION["PROJ4","+proj=merc +nadgrids={name} +no_defs"]'),
        "a PROJ string with +init, by name": projected(f',EXTENSION["PROJ4","+proj=merc +init={name}:foo"]'),
        "a file of a transformation, by name": bound(name),
        "a method of PROJ's, by name": derived(f"PROJ merc +nadgrids={name}"),
        "an authority that is a file": projected(f',AUTHORITY["{name}","x"]'),
        "an authority with +init, by name": projected(f',AUTHORITY["a[ +init={name}","foo"]'),
    }
