// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once
// The machine as machine.toml describes it: plain data that is checked for consistency, without a mesh. Lengths are in
// m, angles in rad, and temperatures in degC where the name says so. Ids are unique within their kind.
// docs/reference/machine.md documents the file key by key.

#include <Eigen/Core>

#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "core/uncertain.h"
#include "mesh/machine/laws.h"
#include "mesh/machine/plausible_range.h"

namespace thermotwin::mesh {

using core::Uncertain;

struct Material {
  std::string id;
  double density = 0;         ///< kg/m^3
  Uncertain specific_heat;    ///< J/(kg K); with a table, that at reference_C
  double conductivity = 0;    ///< W/(m K); with a table, that at reference_C
  Curve specific_heat_table;  ///< over degC, J/(kg K); times specific_heat over its own value at reference_C
  Curve conductivity_table;   ///< over degC, W/(m K)
  std::optional<Eigen::Matrix3d> conductivity_tensor;  ///< W/(m K), instead; axes of the body's home frame
  Uncertain expansion;                                 ///< 1/K
  double young = 0;                                    ///< Pa
  double poisson = 0;
};

/// A body, drawn in machine coordinates at home (all axes at 0), where the frames of all bodies coincide.
struct BodySpec {
  std::string id, material;
  std::filesystem::path cad;  ///< absolute
  double unit_m = 0.001;
  double element_size = 0.05;  ///< m, at size factor 1
  int elements_per_turn = 8;
  std::string parent;         ///< body that carries it; empty: the foundation
  std::string axis;           ///< axis between parent and body; empty: fixed
  bool elastic = true;        ///< false: takes part in heat only (screws)
  int pieces = 1;             ///< unconnected parts that the body is meant to have
  double max_elements = 4e6;  ///< a mesh that would be larger is refused before it is made
  bool lattice = false;       ///< filled with a lattice that is cut at the surface, for faulty geometry
};

enum class AxisKind { linear, rotary };
struct Axis {
  std::string id;  ///< "X", "B", ...
  AxisKind kind = AxisKind::linear;
  Eigen::Vector3d direction;                         ///< unit; positive motion moves the body this way
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< point on a rotary axis, m, home frame
  double low = 0, high = 0;                          ///< travel, m or rad
  bool endless = false;                              ///< rotary without limits: position modulo one turn
  double rapid = 0;                                  ///< m/s or rad/s
  std::string feedback;  ///< linear: "scale" (closed loop), "screw" (motor encoder) or "" (neither)
};

/// A geometric rule that selects triangles; all of its conditions must hold for a triangle's centre and normal.
struct Rule {
  std::string group;                                         ///< named group of the mesh
  std::optional<Eigen::Vector3d> plane_point, plane_normal;  ///< within tolerance of the plane
  std::optional<Eigen::Vector3d> cylinder_point, cylinder_axis;
  double cylinder_radius = 0;                       ///< m; distance to the axis equals it
  std::optional<Eigen::Vector3d> box_min, box_max;  ///< m
  std::optional<Eigen::Vector3d> normal;            ///< within max_angle of the outward normal
  double max_angle = 0.35;                          ///< rad
  double tolerance = 0.0005;                        ///< m, of plane and cylinder
  std::string place;                                ///< where in the file, for messages
};
struct SurfaceSpec {
  std::string id, body;
  std::vector<Rule> any_of;         ///< union of the rules; empty: whole skin
  std::vector<std::string> except;  ///< ids of surfaces of the body to leave out
  std::string place;
};

/// A contact between a surface of a moving body (slave) and one of its base (master), on meshes that do not match. A
/// joint that does not move has axis "". For a mount, master is "" (the ground) and ambient names its temperature.
struct JointSpec {
  std::string id, kind;  ///< "guide", "screw_nut", "bearing", "bolted", "mount"
  std::string slave, master, axis, ambient;
  Uncertain conductance;                             ///< W/(m^2 K)
  ContactLaw law;                                    ///< factors on the conductance
  Uncertain stiffness_normal;                        ///< N/m^3 (per area); 0: no elastic contact
  Uncertain stiffness_tangential;                    ///< N/m^3; along the axis of a linear guide it is 0
  double reach = 0.005;                              ///< m: largest gap between the surfaces that still is contact
  Eigen::Vector3i divide = Eigen::Vector3i::Ones();  ///< cells along x, y, z of each pad
  int sectors = 0;                                   ///< > 0: sectors about sector_axis instead of cells
  Eigen::Vector3d sector_point = Eigen::Vector3d::Zero(), sector_axis = Eigen::Vector3d::UnitZ();
};

/// The linear scale of a closed-loop axis. It fixes the position of the moved body along the axis at the reading head.
/// The tape is fixed to its carrier at one point and expands independently of it.
struct ScaleSpec {
  std::string axis;
  std::string carrier, head_body;  ///< bodies
  Eigen::Vector3d start, end;      ///< m, ends of the tape on the carrier, home frame
  Eigen::Vector3d fixed_at;        ///< m, where the tape is fixed
  Eigen::Vector3d head;            ///< m, reading point on the moved body, home frame
  Uncertain expansion;             ///< 1/K
};

/// The power over one input as a table that is linear between its points and constant beyond them.
struct PowerLaw {
  std::string input;              ///< channel; its absolute value is used
  std::vector<double> at, power;  ///< input unit, W
};

/// The ball screw between its bearings on the carrier and the nut on the moved body. With feedback = "screw" it
/// determines the position of the nut, which then moves with the expansion of the screw.
struct ScrewSpec {
  std::string axis, body, nut_body;  ///< body: the screw's own mesh, elastic = false
  std::string carrier;               ///< its parent: carries the bearings
  Eigen::Vector3d bearing;           ///< m, fixed bearing, home frame
  Eigen::Vector3d nut;               ///< m, nut at home
  Uncertain expansion;               ///< 1/K
  /// Of a screw stretched between two fixed bearings: far_bearing in m, pretension in N at the reference temperature,
  /// axial stiffness of one bearing in N/m (0: rigid).
  std::optional<Eigen::Vector3d> far_bearing;
  double pretension = 0, bearing_stiffness = 0;
};

enum class FilmKind { constant, table, free_convection, rotating_disc };
enum class Orientation { vertical, up, down };
struct FilmSpec {
  std::string id;
  std::vector<std::string> surfaces;
  std::string ambient = "air";  ///< or a volume
  FilmKind kind = FilmKind::constant;
  Uncertain coefficient;  ///< W/(m^2 K), constant part; factor of 1 for the laws below
  Orientation orientation = Orientation::vertical;
  double length = 1.0;           ///< m, characteristic, free convection
  double delta = 3.0;            ///< K, reference temperature difference, free convection
  bool of_temperature = false;   ///< free convection with the surface's own mean temperature, not delta
  PowerLaw table;                ///< table: film coefficient W/(m^2 K) in place of the power
  Uncertain emissivity;          ///< 0: no radiation
  bool exact_radiation = false;  ///< fourth powers; else linearised at the reference temperature
  std::string surroundings;      ///< ambient that it radiates to; "" the film's own
  std::string axis;              ///< rotating_disc: axis or "spindle"
  double radius = 0;             ///< m, of the disc
  double fraction = 1.0;         ///< share of the disc's film that reaches this surface
  std::string state;             ///< channel ("cutting_fluid.on") that multiplies; "" always 1
  double speed_factor = 1.0;     ///< of what speed adds: the disc's own film, a table above its lowest point
  double radiation_load = 0.0;   ///< W/m^2 that shine on it and no ambient explains (sun, a furnace)
};

struct AmbientSpec {
  std::string id;             ///< "air", "foundation", "cutting_fluid"
  Uncertain default_C;        ///< where nothing is measured
  std::string follows;        ///< id of another ambient it equals by default, or ""
  double offset = 0;          ///< K, added to what it follows; without follows: to its channel or default
  bool has_gradient = false;  ///< its temperature changes with height: channel "<id>.gradient_K_m"
  Uncertain gradient;         ///< K/m upwards, where nothing is measured
  double height = 0;          ///< m, where its temperature holds
};

/// The exchange of a volume. A volume is well mixed and has a heat balance of its own: the tank of a cutting fluid, the
/// air of a working area, a control cabinet. It can be the ambient of films, and sources can heat it.
struct VolumeExchange {
  std::string with;       ///< ambient or volume
  Uncertain conductance;  ///< W/K
  std::string state;      ///< channel that multiplies ("door.front.open"); "" always 1
};
struct VolumeSpec {
  std::string id;
  Uncertain capacity;             ///< J/K
  double capacity_per_litre = 0;  ///< J/(K l) where the file states a content, else 0
  std::vector<VolumeExchange> exchanges;
};

/// A one-dimensional channel of a coolant circuit; the temperature is linear along the flow in each cell.
struct CoolantSegment {
  std::string id, surface;
  Uncertain film_coefficient;  ///< W/(m^2 K)
  double volume = 0.0005;      ///< m^3 of fluid
  int cells = 1;
  std::vector<std::string> after{};  ///< segments whose outflows mix at its inlet; empty: the chiller
  double share = std::numeric_limits<double>::quiet_NaN();  ///< of the circuit's flow; NaN: see mesh::flow_network
  std::vector<Eigen::Vector3d> path{};  ///< m, points along the flow; empty: all cells see the whole wall
};
enum class ChillerControl { lag, two_point, pi };
struct CoolantSpec {
  std::string id;
  Uncertain flow;  ///< kg/s
  double specific_heat = 1940, density = 815;
  std::string guide_sensor;  ///< id; "" follows the ambient of guide_ambient
  std::string guide_ambient = "air";
  double guide_offset = 0;        ///< K, set point minus guide reading
  double inlet_offset = 0;        ///< K, inlet temperature minus the value of the inlet channel
  std::string guide_warmed_by;    ///< volume next to the guide sensor (control cabinet), or ""
  double guide_warmed_share = 0;  ///< share of the volume's temperature in the reading
  bool controls_return = false;   ///< true: the return is held at the set point, else the outlet
  double time_constant = 120;     ///< s, of the chiller's outlet
  ChillerControl control = ChillerControl::lag;
  double band = 1.0;       ///< K, two_point: runs from set point + band / 2 down to - band / 2
  double pull_down = 5.0;  ///< K below the set point (the return) that the outlet approaches while the compressor runs
  double drift_up = 5.0;   ///< K above it that the outlet approaches while the compressor rests
  double gain = 2.0;       ///< pi: K of cooling per K of deviation
  double integral_time = 600.0;  ///< s
  double power = 5000.0;         ///< W, largest cooling power
  double after_run = 0;          ///< s that the pump runs on after it is switched off
  double standstill_stop = 0;    ///< s of standstill after which it stops by itself; 0: never
  std::vector<CoolantSegment> segments;
};

/// A place that a source's heat goes to: a surface, a volume, or both sides of a joint, which follows the axis.
struct SourcePlace {
  std::string surface, joint, volume;
  double share = 1.0;        ///< of the source; all shares add to at most 1 (rest: air)
  double slave_share = 0.5;  ///< joint: part that goes to the slave's side
};
struct SourceSpec {
  std::string id;
  std::string drive;              ///< "<drive>.power_W" replaces the laws where it is given
  double drive_loss_share = 1.0;  ///< share of the drive's power that becomes this heat
  Uncertain scale{1.0, 0.0};
  double standstill = 0;       ///< W while the machine is on, in addition to laws or measured power
  double speed_exponent = 0;   ///< exponent of the factor (speed / half the largest speed) on laws of speeds
  std::vector<PowerLaw> laws;  ///< added up, with losses
  std::vector<LossLaw> losses;
  std::vector<SourcePlace> places;
};

struct SensorSpec {
  std::string id, body;           ///< one of body, volume, return_of
  std::string volume, return_of;  ///< in a volume; in the mixed return of a coolant
  Eigen::Vector3d point;          ///< m, home frame; moved to the nearest point of the body
  double offset = 0;              ///< K
  double drift = 0;               ///< K/s from the start of a record
  double lag = 0;                 ///< s, time constant of the reading
  double air_share = 0;           ///< share of the air temperature in the reading; 1: the sensor hangs in the air
  double uncertainty = 0.05;      ///< K, one standard deviation
};

/// Errors of a recorded channel: the drift of its probe, the delay of its clock, an offset.
struct ReadingSpec {
  std::string id;     ///< of the channel in channels.toml
  double drift = 0;   ///< unit of the channel per s from the start of a record
  double shift = 0;   ///< s, delay of the channel
  double offset = 0;  ///< unit of the channel; it does not act on a chiller
};

struct TcpSpec {
  std::string tool_body, tool_surface;    ///< the surface whose rigid motion is the tool's
  Eigen::Vector3d tool_point;             ///< m, home frame
  std::string table_body, table_surface;  ///< the surface whose rigid motion is the table's
  Eigen::Vector3d table_point;            ///< m, centre of the table top, home frame
  double table_radius = 0;                ///< m, reference radius of R0T
};

/// Grid of the workspace: positions per axis, m or rad, rising; the product is the pose grid.
struct Workspace {
  std::vector<std::string> axes;               ///< linear axes of the grid, then B ...
  std::vector<std::vector<double>> positions;  ///< one list an axis
  std::vector<std::string> table_axes;         ///< axes of the table side (B, C)
  std::vector<std::vector<double>> table_positions;
};

struct Machine {
  std::string name, kinematic_chain;
  double reference_C = 20.0;                                 ///< temperature at which the machine has no error
  double plausible_low_C = -40.0, plausible_high_C = 150.0;  ///< measured temperatures outside are rejected
  double coarse = 1.0, standard = 0.55, fine = 0.32;         ///< size factors
  int order = 1;                                             ///< of the tetrahedra: 1 linear, 2 quadratic
  bool lumped_capacity = false;                              ///< diagonal capacity matrix instead of the consistent one
  double spindle_max_rpm = 0;
  std::vector<Material> materials;
  std::vector<BodySpec> bodies;
  std::vector<Axis> axes;
  std::vector<SurfaceSpec> surfaces;
  std::vector<JointSpec> joints;
  std::vector<ScaleSpec> scales;
  std::vector<ScrewSpec> screws;
  std::vector<FilmSpec> films;
  std::vector<AmbientSpec> ambients;
  std::vector<VolumeSpec> volumes;
  std::vector<std::string> doors;  ///< channels "door.<id>.open"
  std::vector<CoolantSpec> coolants;
  std::vector<SourceSpec> sources;
  std::vector<SensorSpec> sensors;
  std::vector<ReadingSpec> readings;
  bool asks_time_of_day = false;  ///< has the channel of the time of day though no table is over it
  TcpSpec tcp;                    ///< only where has_tcp()
  Workspace workspace;
  std::filesystem::path path;  ///< machine.toml
  std::string text;            ///< its text, as read
  std::string hash;            ///< core::content_hash(text)

  // Compiled once: a hundred sources copy or drop a machine.
  Machine();
  Machine(const Machine&);
  Machine(Machine&&) noexcept;
  Machine& operator=(const Machine&);
  Machine& operator=(Machine&&) noexcept;
  ~Machine();

  const Material& material(const std::string& id) const;  ///< ids are known to exist after reading
  int body_index(const std::string& id) const;            ///< -1 if absent
  int axis_index(const std::string& id) const;
  int surface_index(const std::string& id) const;
  int joint_index(const std::string& id) const;
  int sensor_index(const std::string& id) const;
  int ambient_index(const std::string& id) const;
  int volume_index(const std::string& id) const;
  int coolant_index(const std::string& id) const;
  PlausibleRange plausible_range() const;  ///< plausible_C
  /// @throws InputError (place) for a temperature outside plausible_C, with its value in degC if it may be in kelvin
  void require_plausible(double value_C, const std::string& place) const;
  /// Without [tcp] the machine has temperatures and displacements, but no TCP error.
  bool has_tcp() const { return !tcp.tool_body.empty(); }
  /// @return whether a law uses the channel "axis.<id>.clamp.on"
  bool has_clamp(const std::string& axis) const;
  /// @return whether a law uses the channel "axis.<id>.positive.on"
  bool has_direction(const std::string& axis) const;
};

}  // namespace thermotwin::mesh
