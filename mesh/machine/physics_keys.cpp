// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh/machine/physics_keys.h"

namespace thermotwin::mesh {

using core::Absent;
using core::any_number;
using core::KeyTable;
using core::positive;
using core::Range;
using core::required;
namespace key = core::key;

namespace {

// Generous bounds that still catch a wrong unit, and what would overflow in a product.
using range::share, range::specific_heat;
constexpr Range density{0.01, 30000.0};
constexpr Range force{0.0, 1e7};
constexpr Range film_coefficient{0.0, 1e6};
constexpr Range power{-1e9, 1e9};

const KeyTable ambient{
    "ambient",
    "A temperature around the machine: air, foundation, a cutting fluid. Its channel is `<id>.T_C`.",
    {
        key::text("id", required, "Its name, unique among ambients."),
        key::uncertain("default_C", "degC", {-100.0, 500.0}, Absent{"that of the ambient it follows"},
                       "Temperature without a value in the load program or the rows; within `plausible_C`."),
        key::reference("follows", "ambient", Absent{}, "Another ambient whose temperature it takes."),
        key::number("offset_K", "K", {-200.0, 200.0}, 0.0, "Added to what it follows, to its channel or its default."),
        key::uncertain(
            "gradient_K_m", "K/m", {-50.0, 50.0}, Absent{"the same at every height"},
            "Vertical gradient, positive where it is warmer further up; its channel is `<id>.gradient_K_m`."),
        key::number("height_mm", "mm", {-1e5, 1e5}, 0.0, "Height at which its temperature holds, of bodies at home."),
    }};

const KeyTable door{"door",
                    "A door; its channel `door.<id>.open`, 0 or 1, is a state of films and exchanges.",
                    {key::text("id", required, "Its name, unique among doors.")}};

const KeyTable exchange{
    "volume.exchange",
    "An exchange of heat between a volume and what surrounds it.",
    {
        key::reference("with", "ambient or volume", required, "The other side."),
        key::uncertain("conductance_W_K", "W/K", {0.0, 1e9}, required, "Heat flow per difference of temperature."),
        key::reference("state", "channel", Absent{"always"}, "A channel, 0 to 1, that multiplies it."),
    }};

const KeyTable volume{
    "volume",
    "Well-mixed content with a heat balance of its own: a tank, the air of a working area, a cabinet. Its channel "
    "`<id>.T_C` is optional.",
    {
        key::text("id", required, "Its name, unique among volumes."),
        key::uncertain("content_l", "l", {1e-3, 1e7}, Absent{"heat_capacity_J_K"}, "Its content."),
        key::number("density_kg_m3", "kg/m3", density, 1000.0, "Density of the content."),
        key::number("specific_heat_J_kgK", "J/(kg K)", specific_heat, 4180.0, "Specific heat of the content."),
        key::uncertain("heat_capacity_J_K", "J/K", {1e-3, 1e12}, Absent{"content_l"},
                       "Heat capacity instead of a content."),
        key::tables("exchange", exchange, Absent{}, "Exchanges with ambients and other volumes."),
    }};

const KeyTable film{
    "film",
    "Heat transfer from surfaces to an ambient or a volume.",
    {
        key::text("id", required, "Its name, unique among films."),
        key::texts("surfaces", required, "The surfaces that it lies on."),
        key::reference("ambient", "ambient or volume", "air", "What it exchanges heat with."),
        key::word(
            "kind", {"constant", "table", "free_convection", "rotating_disc"}, "constant",
            "The law of its coefficient. rotating_disc contains the still air: its surface takes no second film."),
        key::uncertain("film_coefficient_W_m2K", "W/(m2 K)", film_coefficient, Absent{"a law"},
                       "Film coefficient of a constant film; of a table, one for each of `at`.")
            .or_list(),
        key::uncertain("factor", "1", {0.0, 1e3}, 1.0, "Factor on the coefficient of a law or table."),
        key::word("orientation", {"vertical", "up", "down"}, "vertical",
                  "free_convection: up is a plate that heats the air above it."),
        key::number("length_m", "m", {1e-3, 100.0}, 1.0, "free_convection: characteristic length."),
        key::number("delta_K", "K", {1e-3, 500.0}, 3.0,
                    "free_convection: difference of temperature that the law is taken at."),
        key::flag(
            "of_temperature", false,
            "free_convection: the law is taken at the mean temperature difference of the surface; steps are iterated."),
        key::reference("input", "channel", Absent{"not a table"},
                       "table: the channel whose absolute value it is over; of `day.time_h` the hour of the day."),
        key::numbers("at", "", any_number, Absent{"not a table"},
                     "table: rising values of the input; linear between them, constant beyond."),
        key::text("axis", Absent{"not a disc"},
                  "rotating_disc: a rotary axis or \"spindle\"; the film rises with its speed."),
        key::number("radius_mm", "mm", {0.01, 1e5}, Absent{"not a disc"}, "rotating_disc: its radius."),
        key::number("fraction", "1", share, 1.0, "rotating_disc: share of the surface that turns."),
        key::number("speed_factor", "1", {0.0, 1e3}, 1.0,
                    "Factor on the speed-dependent part of a rotating_disc or of a table over a speed."),
        key::uncertain("emissivity", "1", share, 0.0, "Above 0: radiation is added."),
        key::word("radiation", {"linear", "exact"}, "linear",
                  "linear: at reference_C, with a warning where it errs by more than 1 %; exact: by fourth powers."),
        key::reference("surroundings", "ambient", Absent{"its own ambient"},
                       "Ambient that it radiates to, at its temperature at height_mm: a gradient acts on convection."),
        key::number("radiation_load_W_m2", "W/m2", {-1e5, 1e5}, 0.0,
                    "Absorbed radiation of another origin: sun, a furnace."),
        key::reference("state", "channel", Absent{"always"}, "A channel, 0 to 1, that multiplies the film."),
    }};

const KeyTable segment{
    "coolant.segment",
    "A piece of a coolant's path, in order of flow.",
    {
        key::text("id", required, "Its name, unique within the coolant."),
        key::reference("surface", "surface", required, "The wall that the coolant flows along."),
        key::uncertain("film_coefficient_W_m2K", "W/(m2 K)", film_coefficient, required,
                       "Film coefficient of the wall; it also holds for standing fluid."),
        key::number("volume_l", "l", {1e-6, 1e6}, 0.5, "Volume of the fluid in it."),
        key::whole("cells", 1, 100, 1.0, "Parts along the flow; in each the temperature is linear."),
        key::points("path_mm", "mm", Absent{"each cell sees the whole wall"}, "Points along the flow over the wall."),
        key::texts("after", Absent{"the segment before it"},
                   "Segments whose outflows mix at its inlet, or \"chiller\"."),
        key::number("share", "1", {1e-6, 1.0}, Absent{"divided evenly among branches"},
                    "Its share of the circuit's flow."),
    }};

const KeyTable coolant{
    "coolant",
    "A coolant circuit with its chiller. Its channels are `coolant.<id>.on` and `coolant.<id>.inlet_T_C`.",
    {
        key::text("id", required, "Its name, unique among coolants."),
        key::uncertain("flow_kg_s", "kg/s", {1e-9, 1e4}, required, "Mass flow."),
        key::number("specific_heat_J_kgK", "J/(kg K)", specific_heat, 1940.0, "Specific heat of the fluid."),
        key::number("density_kg_m3", "kg/m3", density, 815.0, "Density of the fluid."),
        key::reference("guide_sensor", "sensor", Absent{"guide_ambient"},
                       "The sensor whose reading, plus guide_offset_K, is the set point."),
        key::reference("guide_ambient", "ambient", "air",
                       "The ambient whose temperature, plus guide_offset_K, is the set point without guide_sensor."),
        key::number("guide_offset_K", "K", {-100.0, 100.0}, 0.0, "Set point minus the temperature that guides it."),
        key::number("inlet_offset_K", "K", {-100.0, 100.0}, 0.0, "True inlet temperature minus the measured one."),
        key::reference("guide_warmed_by", "volume", Absent{},
                       "A volume beside the guide sensor that warms its reading."),
        key::number("guide_warmed_share", "1", share, Absent{}, "The reading's share of that volume's temperature."),
        key::word("controls", {"outlet", "return"}, "outlet",
                  "The temperature that is controlled to the set point: outlet or return."),
        key::number("time_constant_s", "s", {1e-3, 1e9}, 120.0, "Time constant of the outlet."),
        key::word("control", {"lag", "two_point", "pi"}, "lag",
                  "lag: the outlet follows the set point; two_point: a compressor that switches; pi: a PI controller."),
        key::number("band_K", "K", positive, 1.0,
                    "two_point: the compressor starts half of it above the set point and stops half of it below."),
        key::number("pull_down_K", "K", {0.0, 1e3}, Absent{"5, at least the band"},
                    "two_point: the running compressor cools towards the set point minus this."),
        key::number("drift_up_K", "K", {0.0, 1e3}, Absent{"5, at least the band; controls = \"return\": 0"},
                    "two_point: the outlet at rest warms towards the set point plus this."),
        key::number("gain", "1", {1e-6, 1e4}, 2.0, "pi: K of cooling below the return per K of deviation."),
        key::number("integral_time_s", "s", {1e-3, 1e9}, 600.0, "pi: integral time."),
        key::number("cooling_power_W", "W", {1e-3, 1e9}, 5000.0, "pi: largest cooling power."),
        key::number("after_run_s", "s", {0.0, 1e7}, 0.0,
                    "Time that the pump runs on after it is switched off, in load programs."),
        key::number("standstill_stop_s", "s", {0.0, 1e7}, 0.0,
                    "Standstill after which the pump stops, in load programs; 0: never."),
        key::tables("segment", segment, required, "Its path, one or more segments."),
    }};

const KeyTable law{
    "source.law",
    "A table of a channel (`input`), or a loss by kind (`kind`); [losses.md](losses.md) has the equations.",
    {
        key::reference("input", "channel", Absent{"a kind"},
                       "table: the channel whose absolute value it is over; of `day.time_h` the hour of the day."),
        key::numbers("at", "", any_number, Absent{"a kind"},
                     "table: rising values of the input; linear between them, constant beyond."),
        key::numbers("power_W", "W", power, Absent{"a kind"}, "table: the power at each of them."),
        key::word("kind", {"bearing", "guide", "ball_screw", "motor", "holding"}, Absent{"a table"},
                  "The kind of a loss."),
        key::text("motion", Absent{"a table"}, "What moves it: \"spindle\" or the id of an axis."),
        key::number("ratio", "1", {1e-6, 1e6}, 1.0, "bearing, motor: its turns per turn of spindle, axis or screw."),
        key::number("pitch_mm", "mm", {1e-3, 1e4}, Absent{},
                    "ball_screw: its lead; bearing and motor of a linear axis: the lead of the screw they turn with."),
        key::number("f0", "1", {0.0, 100.0}, Absent{}, "bearing: factor of the lubricant's friction."),
        key::number("f1", "1", share, 0.0, "bearing: factor of the load's friction."),
        key::number("mean_diameter_mm", "mm", {0.1, 1e4}, Absent{}, "bearing, ball_screw: mean diameter."),
        key::number("viscosity_mm2_s", "mm2/s", {1e-3, 1e6}, Absent{},
                    "bearing: kinematic viscosity of its lubricant."),
        key::number("load_N", "N", force, 0.0, "bearing, ball_screw: its load."),
        key::whole("count", 1, 10000, 1.0, "bearing: how many there are."),
        key::number("coulomb_N", "N", force, 0.0, "guide: friction force that does not depend on speed."),
        key::number("viscous_N_s_m", "N s/m", force, 0.0, "guide: friction force per speed."),
        key::number("preload_N", "N", force, 0.0, "ball_screw: preload of its nut."),
        key::number("efficiency", "1", {0.1, 1.0}, 0.9, "ball_screw: efficiency under load."),
        key::number("torque_Nm", "N m", {0.0, 1e6}, 0.0, "motor: its torque; with `at_rpm`, one for each speed.")
            .or_list(),
        key::numbers("at_rpm", "rpm", {0.0, 1e6}, Absent{"the same at all speeds"},
                     "motor: rising speeds of the motor."),
        key::number("torque_constant_Nm_A", "N m/A", {1e-4, 1e4}, Absent{}, "motor, holding: torque per current."),
        key::number("resistance_ohm", "ohm", {0.0, 1e4}, Absent{}, "motor, holding: of one phase at 20 degC."),
        key::whole("phases", 1, 12, 3.0, "motor, holding: number of phases."),
        key::number("winding_C", "degC", {-50.0, 250.0}, 20.0, "motor, holding: temperature of the winding."),
        key::number("hysteresis_W", "W", {0.0, 1e6}, 0.0, "motor: hysteresis losses at `nominal_rpm`."),
        key::number("eddy_W", "W", {0.0, 1e6}, 0.0, "motor: eddy-current losses at `nominal_rpm`."),
        key::number("nominal_rpm", "rpm", {1e-3, 1e6}, Absent{}, "motor: speed at which hysteresis_W and eddy_W hold."),
        key::number("balanced_at_deg", "deg", {-360.0, 360.0}, 0.0, "holding: position of the axis without a moment."),
        key::number("full_power_W", "W", {0.0, 1e6}, Absent{"from the motor's data"},
                    "holding: power with a horizontal lever arm."),
        key::number("linear_share", "1", share, 0.0,
                    "holding: share of that power that is proportional to the moment instead of its square."),
        key::number("friction_share", "1", share, 0.0,
                    "holding: friction over the largest moment. The motor holds more after a motion against the moment "
                    "than after one with it; `balanced_at_deg` is where the mass hangs."),
        key::number("mass_kg", "kg", {0.0, 1e6}, Absent{"full_power_W"}, "holding: mass that is held."),
        key::number("lever_mm", "mm", {0.0, 1e5}, Absent{"full_power_W"}, "holding: its distance from the axis."),
    }};

const KeyTable place{
    "source.place",
    "Where a share of a source's heat goes: one of surface, joint and volume.",
    {
        key::reference("surface", "surface", Absent{}, "A surface that it enters through."),
        key::reference("joint", "joint", Absent{}, "A joint, on both of its sides."),
        key::reference("volume", "volume", Absent{}, "A volume: the pump of a cutting fluid."),
        key::number("share", "1", share, 1.0,
                    "Share of the source's power; what all shares leave of 1 goes to the air, outside the model."),
        key::number("slave_share", "1", share, 0.5, "joint: share of the slave's side."),
    }};

const KeyTable source{
    "source",
    "A source of heat: a drive's losses, friction, a pump.",
    {
        key::text("id", required, "Its name, unique among sources."),
        key::text("drive", Absent{"laws only"},
                  "A drive; its channel `<drive>.power_W` replaces the laws where it is measured."),
        key::number("drive_loss_share", "1", share, 1.0, "Share of the drive's measured power that becomes heat here."),
        key::uncertain("scale", "1", {0.0, 1e6}, 1.0, "Factor on the power; its uncertainty is that of the power."),
        key::number("standstill_W", "W", {-1e6, 1e6}, 0.0, "Power added while `machine.on`, beside laws or drive."),
        key::number("speed_exponent", "1", {-5.0, 5.0}, 0.0,
                    "Exponent of the factor (speed / half the largest speed) on laws of speeds."),
        key::tables("law", law, Absent{"the drive's power"}, "Laws of its power; all are added up."),
        key::tables("place", place, required, "Where the heat goes."),
    }};

}  // namespace

const KeyTable& ambient_keys() { return ambient; }
const KeyTable& door_keys() { return door; }
const KeyTable& volume_keys() { return volume; }
const KeyTable& film_keys() { return film; }
const KeyTable& coolant_keys() { return coolant; }
const KeyTable& source_keys() { return source; }

}  // namespace thermotwin::mesh
