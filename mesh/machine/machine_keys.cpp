// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/machine/machine_keys.h"

#include "mesh/machine/physics_keys.h"

namespace thermotwin::mesh {

using core::Absent;
using core::any_number;
using core::KeyTable;
using core::non_negative;
using core::positive;
using core::Range;
using core::required;
namespace key = core::key;

namespace {

// Generous bounds that still catch a wrong unit.
using range::share, range::specific_heat;
constexpr Range expansion{-1e-4, 1e-3}, conductivity{1e-3, 5000.0};
constexpr Range pressure{1e-6, 1e4};

const KeyTable mesh_sizes{
    "mesh",
    "Sizes and order of the meshes.",
    {
        key::number("coarse", "1", {0.01, 100.0}, 1.0, "Size factor of `--size coarse`."),
        key::number("standard", "1", {0.01, 100.0}, 0.55, "Size factor of `--size standard`."),
        key::number("fine", "1", {0.01, 100.0}, 0.32, "Size factor of `--size fine`."),
        key::whole("order", 1, 2, 1.0, "Order of the tetrahedra; `--mesh-order` overrides it."),
        key::word("capacity", {"consistent", "lumped"}, "consistent", "Form of the capacity matrix."),
    }};

const KeyTable specific_heat_table{
    "material.specific_heat_table",
    "Specific heat over temperature, linear between the points, constant beyond them.",
    {
        key::numbers("T_C", "degC", any_number, required, "Rising temperatures."),
        key::numbers("J_kgK", "J/(kg K)", specific_heat, required, "The specific heat at each of them."),
    }};

const KeyTable conductivity_table{
    "material.conductivity_table",
    "Conductivity over temperature, linear between the points, constant beyond them.",
    {
        key::numbers("T_C", "degC", any_number, required, "Rising temperatures."),
        key::numbers("W_mK", "W/(m K)", conductivity, required, "The conductivity at each of them."),
    }};

const KeyTable material{
    "material",
    "A material of bodies.",
    {
        key::text("id", required, "Its name, unique among materials."),
        key::number("density_kg_m3", "kg/m3", {1.0, 30000.0}, required, "Density."),
        key::uncertain("specific_heat_J_kgK", "J/(kg K)", specific_heat, Absent{"specific_heat_table"},
                       "Specific heat."),
        key::table("specific_heat_table", specific_heat_table, Absent{}, "Specific heat over temperature."),
        key::number("conductivity_W_mK", "W/(m K)", conductivity, Absent{"another form of it"}, "Conductivity."),
        key::table("conductivity_table", conductivity_table, Absent{}, "Conductivity over temperature."),
        key::numbers(
            "conductivity_tensor_W_mK", "W/(m K)", any_number, Absent{},
            "[xx, yy, zz] or [xx, yy, zz, xy, yz, zx] along the machine's axes at home; it turns with the body."),
        key::uncertain("expansion_1_K", "1/K", expansion, required, "Linear thermal expansion."),
        key::number("young_GPa", "GPa", {1e-3, 2000.0}, required, "Young's modulus."),
        key::number("poisson", "1", {-0.99, 0.499}, required, "Poisson's ratio."),
    }};

const KeyTable body{
    "body",
    "A body of the machine, drawn in machine coordinates at home.",
    {
        key::text("id", required, "Its name, unique among bodies."),
        key::reference("material", "material", required, "Id of its material."),
        key::text("cad", required,
                  "Its file, relative to machine.toml: .step, .iges, .brep, .stl, .obj, .ply, .3mf, .gltf, .glb; "
                  "or a mesh: .msh, .vtu, .inp."),
        key::word("unit", {"mm", "m", "in"}, "mm", "Unit of the file's coordinates."),
        key::number("element_size_mm", "mm", {0.01, 10000.0}, required,
                    "Edge length of its elements at size factor 1."),
        key::whole("elements_per_turn", 3, 360, 8.0, "Elements on the circumference of a round surface."),
        key::whole("pieces", 1, 1000, 1.0,
                   "Unconnected parts that it is meant to have; another number is an error. An elastic body has one."),
        key::number("max_elements", "1", {1000.0, 1e9}, 4e6,
                    "A mesh that would have more is refused before it is made."),
        key::word("mesher", {"surface", "lattice"}, "surface",
                  "surface: the faces are meshed, then the volume; lattice: for faulty geometry, a regular lattice "
                  "is cut at the surface, which chamfers edges and loses walls thinner than element_size_mm."),
        key::reference("parent", "body", Absent{"stands on the ground"}, "The body that carries it."),
        key::reference("axis", "axis", Absent{"fixed to its parent"}, "The axis between parent and body."),
        key::flag("elastic", true,
                  "true: it deforms, and joints with stiffness hold it in all six directions; false: it only conducts "
                  "and stores heat."),
    }};

const KeyTable axis{
    "axis",
    "A linear or rotary axis.",
    {
        key::text("id", required, "Its name, unique among axes."),
        key::word("kind", {"linear", "rotary"}, required, "How it moves."),
        key::point(
            "direction", "", required,
            "Motion of the body that the axis carries at a positive command, or the rotation's axis; of any length. "
            "A table that carries the workpiece thus moves against the tool's relative motion of ISO 841."),
        key::point("origin_mm", "mm", Absent{"the origin"}, "A point on the axis of a rotary one."),
        key::numbers("travel_mm", "mm", any_number, Absent{"rotary"}, "[low, high] of a linear axis."),
        key::numbers("travel_deg", "deg", any_number, Absent{"linear or endless"}, "[low, high] of a rotary axis."),
        key::flag("endless", false, "A rotary axis without limits."),
        key::number("rapid_mm_min", "mm/min", non_negative, 0.0, "Fastest feed of a linear axis; 0: no limit."),
        key::number("rapid_deg_min", "deg/min", non_negative, 0.0, "Fastest feed of a rotary axis; 0: no limit."),
        key::word("feedback", {"scale", "screw"}, Absent{"the scale if there is one, else the screw"},
                  "What a linear axis is positioned by: its scale, or its motor's encoder."),
    }};

const KeyTable rule{
    "surface.rule",
    "Conditions that all hold for a triangle of the surface.",
    {
        key::text("group", Absent{}, "Name of a group of the file."),
        key::point("plane_point_mm", "mm", Absent{}, "A point of a plane that the triangle's corners lie in."),
        key::point("plane_normal", "", Absent{},
                   "The plane's normal; its sign has no effect. Of a sheet thinner than the tolerance the side in the "
                   "plane counts."),
        key::point("cylinder_point_mm", "mm", Absent{}, "A point on the axis of a cylinder."),
        key::point("cylinder_axis", "", Absent{}, "Direction of the cylinder's axis."),
        key::number("cylinder_radius_mm", "mm", positive, Absent{}, "The cylinder's radius."),
        key::point(
            "box_min_mm", "mm", Absent{},
            "Lower corner of a box around the triangle's centre. Whole triangles are taken, so the area depends on the "
            "mesh; `mesh` prints the area cut at the box beside it."),
        key::point("box_max_mm", "mm", Absent{}, "Upper corner of the box."),
        key::point("normal", "", Absent{}, "Direction that the triangle faces."),
        key::number("max_angle_deg", "deg", {0.0, 180.0}, Absent{"20"}, "Largest angle to `normal`."),
        key::number("tolerance_mm", "mm", non_negative, Absent{"0.5"}, "Largest distance from plane or cylinder."),
    }};

const KeyTable surface{
    "surface",
    "A part of the skin of a body. Without a rule it is the whole skin.",
    {
        key::text("id", required, "Its name, unique among surfaces."),
        key::reference("body", "body", required, "The body whose skin it is of."),
        key::table("rule", rule, Absent{"`rules`, or the whole skin"}, "Which triangles belong to it."),
        key::tables("rules", rule, Absent{}, "Several rules: triangles that fit any of them."),
        key::texts("except", Absent{}, "Surfaces of the same body to leave out."),
    }};

const KeyTable joint{
    "joint",
    "A contact between the surfaces of two bodies, or of a body and the ground.",
    {
        key::text("id", required, "Its name, unique among joints."),
        key::word("kind", {"guide", "screw_nut", "bearing", "bolted", "mount"}, required, "What it is."),
        key::reference("slave", "surface", required,
                       "Surface of the moving body; the part of it that the master covers is the contact."),
        key::reference("master", "surface", Absent{"a mount"}, "Surface of its base."),
        key::reference("ambient", "ambient", Absent{"not a mount"},
                       "Temperature of the ground that a mount stands on; the ground does not expand."),
        key::reference("axis", "axis", Absent{"does not move"}, "The axis that moves the slave along the master."),
        key::uncertain("conductance_W_m2K", "W/(m2 K)", {0.0, 1e9}, required, "Contact conductance."),
        key::uncertain("pressure_MPa", "MPa", pressure, Absent{"no law of pressure"},
                       "Mean pressure in the contact; the conductance is then that at the nominal pressure."),
        key::number("nominal_pressure_MPa", "MPa", pressure, Absent{},
                    "Pressure at which the conductance holds; with the exponent, not beside a table."),
        key::number("pressure_exponent", "1", {0.0, 2.0}, 0.95,
                    "The conductance rises with this power of the pressure (0.95: rough surfaces)."),
        key::numbers("pressure_at_MPa", "MPa", pressure, Absent{},
                     "Rising pressures of a table, instead of the exponent."),
        key::numbers("pressure_factor", "1", {0.0, 1e4}, Absent{}, "Factor on the conductance at each of them."),
        key::numbers("temperature_at_C", "degC", {-100.0, 500.0}, Absent{},
                     "A table over the mean temperature of both sides: rising temperatures."),
        key::numbers("temperature_factor", "1", {1e-4, 1e4}, Absent{}, "Factor on the conductance at each of them."),
        key::number("clamped_pressure_MPa", "MPa", pressure, Absent{}, "Pressure while the joint's axis is clamped."),
        key::uncertain("stiffness_normal_N_mm3", "N/mm3", non_negative, 0.0,
                       "Normal stiffness per area; 0: no elastic contact."),
        key::uncertain("stiffness_tangential_N_mm3", "N/mm3", non_negative, 0.0,
                       "Tangential stiffness per area; a linear guide is free along its axis."),
        key::number("reach_mm", "mm", positive, 5.0, "Largest gap that still is contact."),
        key::point("divide", "1", Absent{"one cell a pad"},
                   "Cells along x, y, z of each pad. A pad carries the mean motion of its surface and holds no "
                   "rotation; 2 x 2 or more do."),
        key::whole("sectors", 0, 1000, 0.0, "Sectors about an axis instead of cells; 3 or more hold rotations."),
        key::point("sector_point_mm", "mm", Absent{}, "A point on the axis of the sectors."),
        key::point("sector_axis", "", Absent{}, "Direction of that axis."),
    }};

const KeyTable scale{
    "scale",
    "The linear scale of a closed-loop axis.",
    {
        key::reference("axis", "axis", required, "The axis that it measures."),
        key::reference("carrier", "body", required, "The body that it is fixed to."),
        key::reference("head_body", "body", required, "The body of its reading head."),
        key::point("start_mm", "mm", required, "One end of the tape."),
        key::point("end_mm", "mm", required, "Its other end."),
        key::point("fixed_at_mm", "mm", required, "Where the tape is fixed to its carrier."),
        key::point("head_mm", "mm", required, "Reading point at home."),
        key::uncertain("expansion_1_K", "1/K", expansion, required, "Linear thermal expansion of the tape."),
    }};

const KeyTable screw{
    "screw",
    "The ball screw of a linear axis; under `feedback = \"screw\"` it holds the position.",
    {
        key::reference("axis", "axis", required, "The axis that it drives."),
        key::reference("body", "body", required,
                       "Its own body, `elastic = false`; that body's parent carries the bearings."),
        key::reference("nut_body", "body", required, "The body that its nut is fixed to."),
        key::point("fixed_bearing_mm", "mm", required, "The bearing that holds it along its axis."),
        key::point("nut_mm", "mm", required, "The nut at home; the screw's axis runs through it and the bearing."),
        key::uncertain("expansion_1_K", "1/K", expansion, required, "Linear thermal expansion of the screw."),
        key::word("bearings", {"fixed_free", "fixed_supported", "fixed_fixed"}, "fixed_free",
                  "How its ends are held; fixed_fixed: stretched, it pulls at both bearings."),
        key::point("far_bearing_mm", "mm", Absent{"not fixed_fixed"}, "The other bearing of a stretched screw."),
        key::number(
            "pretension_N", "N", {0.0, 1e7}, Absent{"not fixed_fixed"},
            "Tension at the reference temperature; the linear model only warns of a slack screw by it, so it takes "
            "no std_percent."),
        key::number("bearing_stiffness_N_um", "N/um", {0.0, 1e6}, 0.0,
                    "Axial stiffness of each bearing of a stretched screw; 0: rigid."),
    }};

const KeyTable sensor{
    "sensor",
    "A temperature sensor.",
    {
        key::text("id", required, "Its name, unique among sensors."),
        key::reference("body", "body", Absent{"volume or return_of"}, "The body that it is in or on."),
        key::point("point_mm", "mm", Absent{"volume or return_of"},
                   "Its position; beside the body, the nearest point of the body is read."),
        key::reference("volume", "volume", Absent{}, "It reads this volume instead."),
        key::reference("return_of", "coolant", Absent{}, "It reads the mixed return of this coolant instead."),
        key::number("offset_K", "K", {-100.0, 100.0}, 0.0, "Reading minus true temperature."),
        key::number("drift_K_h", "K/h", {-100.0, 100.0}, 0.0, "Drift of the reading, as a diagnosis finds it."),
        key::number("time_constant_s", "s", {0.0, 1e6}, 0.0, "Lag of the reading, as a diagnosis finds it."),
        key::number("air_share", "1", share, 0.0,
                    "Share of the air in the reading; 1: detached. The air is that of the nearest film of its body: "
                    "its ambient, "
                    "or its volume."),
        key::number("uncertainty_K", "K", positive, 0.05, "One standard deviation of a reading."),
    }};

const KeyTable reading{
    "reading",
    "Error of a recorded channel, as a diagnosis finds it.",
    {
        key::text("id", required,
                  "The channel's name in channels.toml; or `temperature` or `displacement` for all of them, "
                  "`displacement.dx` for all of a quantity."),
        key::number("drift_1_h", "1/h", {-1e4, 1e4}, 0.0, "Drift, in the channel's unit per hour."),
        key::number("shift_s", "s", {-1e6, 1e6}, 0.0, "Delay of the record."),
        key::number("offset", "1", {-1e4, 1e4}, 0.0,
                    "Offset in the channel's unit; that of a guide sensor affects the record only."),
    }};

const KeyTable tcp{
    "tcp",
    "The tool centre point and its table. mesh, simulate and export work without it; all other verbs need it.",
    {
        key::reference("tool_body", "body", required, "The body that the tool is clamped in."),
        key::reference(
            "tool_surface", "surface", required,
            "The surface whose mean motion the tool follows: the face around the spindle, its middle on the spindle's "
            "axis. Growth between its middle and the tool is not in the TCP error."),
        key::point("tool_point_mm", "mm", required, "The tool centre point at home."),
        key::reference("table_body", "body", required, "The body that the workpiece stands on."),
        key::reference("table_surface", "surface", required, "The surface whose mean motion the workpiece follows."),
        key::point("table_point_mm", "mm", required, "A point of the table at home, on its axis where it turns."),
        key::number("table_radius_mm", "mm", non_negative, 0.0,
                    "Radius at which the table's radial growth R0T is evaluated; its part of the TCP error is "
                    "proportional to the distance from the table's axis."),
    }};

const KeyTable workspace{
    "workspace",
    "Positions of the axes whose product is the grid of poses; usually three an axis.",
    {
        key::numbers("<axis>_mm", "mm", any_number, Absent{"the axis stands at 0"},
                     "Rising positions of a linear axis within its travel."),
        key::numbers("<axis>_deg", "deg", any_number, Absent{"the axis stands at 0"},
                     "Rising positions of a rotary axis: the table side's own grid, or where it carries the tool, "
                     "part of the tool side's."),
    }};

KeyTable table_of_machine() {
  return {"machine.toml",
          "A machine: bodies, axes, joints, heat sources, films and coolants, sensors and the tool centre point.\n\n"
          "A number marked *u* may be written `{value = 5.0, std_percent = 10}`. The percentage is its standard "
          "deviation,\nthe prior of the observer, of a diagnosis and of studies. Without it the [default "
          "priors](priors.md) hold.",
          {
              key::schema(),
              key::text("name", required, "The machine's name."),
              key::text("kinematic_chain", "",
                        "Its structure in the notation of ISO 10791-1: \"V [w C' B' b Y X Z (C1) t]\"."),
              key::number("reference_C", "degC", {-50.0, 100.0}, 20.0,
                          "Uniform temperature at which there is no thermal error."),
              key::numbers("plausible_C", "degC", {-273.15, 2000.0}, Absent{"[-40, 150]"},
                           "[low, high] that readings, programs and measurements keep to."),
              key::number("spindle_max_rpm", "rpm", {0.0, 1e6}, 0.0, "Fastest speed of the spindle; 0: no limit."),
              key::table("mesh", mesh_sizes, Absent{"its defaults"}, "Sizes of the meshes."),
              key::tables("material", material, Absent{}, "Materials."),
              key::tables("body", body, required, "Bodies."),
              key::tables("axis", axis, Absent{}, "Axes."),
              key::tables("surface", surface, Absent{}, "Surfaces of bodies."),
              key::tables("joint", joint, Absent{}, "Joints."),
              key::tables("scale", scale, Absent{}, "Linear scales."),
              key::tables("screw", screw, Absent{}, "Ball screws."),
              key::tables("sensor", sensor, Absent{}, "Temperature sensors."),
              key::tables("reading", reading, Absent{}, "Errors of recorded channels."),
              key::table("tcp", tcp, Absent{"no TCP error"}, "The tool centre point."),
              key::tables("ambient", ambient_keys(), Absent{}, "Ambient temperatures."),
              key::tables("door", door_keys(), Absent{}, "Doors."),
              key::tables("volume", volume_keys(), Absent{}, "Volumes."),
              key::tables("film", film_keys(), Absent{}, "Films."),
              key::tables("coolant", coolant_keys(), Absent{}, "Coolants."),
              key::tables("source", source_keys(), Absent{}, "Sources of heat."),
              key::table("workspace", workspace, Absent{"the home pose alone"}, "The grid of poses."),
          }};
}

}  // namespace

const KeyTable& machine_keys() {
  static const KeyTable table = table_of_machine();
  return table;
}

}  // namespace thermotwin::mesh
