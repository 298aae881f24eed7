// SPDX-License-Identifier: GPL-3.0-or-later
// Films, heat sources and their amplitudes in a CalculiX deck. ccx takes one film and one flux a
// triangle, and one flux a node: what meets there is added up beforehand.

#include "solver/export/calculix_loads.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "solver/export/calculix_model.h"
#include "solver/operation/layout.h"

namespace thermotwin::solver::calculix {

using Eigen::Index;

namespace {

/// One value an increment.
using Series = std::vector<double>;

bool is_constant(const Series& series) {
  return std::all_of(series.begin(), series.end(), [&](double x) { return x == series.front(); });
}

bool is_zero(const Series& series) {
  return std::all_of(series.begin(), series.end(), [](double x) { return x == 0.0; });
}

Series sum(const std::vector<Series>& all, const std::vector<double>& weights) {
  Series total(all.front().size(), 0.0);
  for (std::size_t i = 0; i < all.size(); ++i)
    for (std::size_t k = 0; k < total.size(); ++k) total[k] += weights[i] * all[i][k];
  return total;
}

/// A load's number, or the amplitude that it is multiplied by.
struct Value {
  double magnitude;
  std::string amplitude;  ///< empty: constant
};

/// Boundary triangles by body and number of the element's face.
using Faces = std::map<std::pair<int, int>, std::vector<Index>>;

class Writer {
public:
  Writer(Model& model, const Program& program, const std::vector<std::vector<ContactPoint>>& contact)
      : model_(model),
        program_(program),
        contact_(contact),
        operating_(program.operating) {}

  Loads text() {
    collect_films();
    collect_sources();
    write_films();
    write_fluxes();
    write_point_fluxes();
    note_motion();
    return std::move(loads_);
  }

private:
  struct Film {
    std::string id;
    Series coefficient, sink;  ///< W/(m^2 K), degC
  };
  struct Flux {
    std::string id;
    Series power;  ///< W/m^2 on triangles, W at nodes
  };

  template <class Of>
  Series series(const Of& of) const {
    Series values;
    for (const Eigen::VectorXd& row : program_.rows) values.push_back(of(row));
    return values;
  }

  double start_C() const {
    return model_.options.program ? model_.options.program->initial_C() : model_.machine().reference_C;
  }

  /// What a film or mount gives heat to, degC: its input over its coefficient.
  Series sink(int term, const Series& coefficient) const {
    const std::vector<Input>& inputs = operating_.layout().inputs;
    const auto input = std::find_if(inputs.begin(), inputs.end(), [&](const Input& i) {
      return i.term == term && (i.kind == InputKind::film_ambient || i.kind == InputKind::contact_ambient);
    });
    Series values(coefficient.size(), start_C());
    if (input == inputs.end()) return values;
    constexpr double digits = 1e9;  // the quotient's rounding must not look like a change
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (coefficient[i] != 0.0) {
        values[i] = std::round((program_.coefficients[i].q[input - inputs.begin()] / coefficient[i] +
                                model_.machine().reference_C) *
                               digits) /
                    digits;
      }
    }
    return values;
  }
  /// Adds the item to every triangle of the surface. @return false where its body is not in the deck
  bool put(const std::string& surface, int item, std::map<std::pair<int, int>, std::vector<int>>& of_face) const {
    const int index = model_.machine().surface_index(surface), body = model_.body_of_surface(index);
    if (!model_.takes(body)) return false;
    for (const int face : model_.mesh.surfaces[index]) of_face[{body, face}].push_back(item);
    return true;
  }

  void collect_films() {
    const mesh::Machine& machine = model_.machine();
    const auto add = [&](const std::string& id, const std::vector<std::string>& surfaces, Series coefficient,
                         Series sink) {
      if (is_zero(coefficient)) return;
      bool any = false;
      for (const std::string& surface : surfaces) any = put(surface, films_.size(), films_of_face_) || any;
      if (any) films_.push_back({id, std::move(coefficient), std::move(sink)});
    };
    int term = -1;
    for (std::size_t f = 0; f < machine.films.size(); ++f) {
      const mesh::FilmSpec& film = machine.films[f];
      const Series coefficient = program_.coefficient(TermKind::film, f, &term);
      const std::size_t before = films_.size();
      add(film.id, film.surfaces, coefficient, sink(term, coefficient));
      if (films_.size() > before) note_film(film);
    }
    for (std::size_t j = 0; j < machine.joints.size(); ++j) {
      if (machine.joints[j].master.empty()) {
        const Series coefficient = program_.coefficient(TermKind::contact, j, &term);
        add(machine.joints[j].id, {machine.joints[j].slave}, coefficient, sink(term, coefficient));
      }
    }
    for (const mesh::CoolantSpec& coolant : machine.coolants) {
      const int inlet = operating_.channels().index("coolant." + coolant.id + ".inlet_T_C");
      const Series fluid = series(
          [&](const Eigen::VectorXd& row) { return inlet >= 0 && std::isfinite(row[inlet]) ? row[inlet] : start_C(); });
      const std::size_t before = films_.size();
      for (const mesh::CoolantSegment& segment : coolant.segments) {
        add(coolant.id + "." + segment.id, {segment.surface},
            Series(program_.rows.size(), segment.film_coefficient.value), fluid);
      }
      if (films_.size() > before) {
        model_.notes.push_back(fmt::format(
            "coolant {}: its walls are films against {}; its warming along the path, its stops and its chiller are not "
            "in the deck",
            coolant.id, is_constant(fluid) ? fmt::format("{:.4g} degC", fluid.front()) : "its inlet temperature"));
      }
    }
  }

  void note_film(const mesh::FilmSpec& film) {
    const mesh::Machine& machine = model_.machine();
    const int ambient = machine.ambient_index(film.ambient);
    if (ambient < 0) {
      model_.notes.push_back(fmt::format("film {} exchanges with volume {}, which the deck keeps at {:.4g} degC",
                                         film.id, film.ambient, start_C()));
    } else if (machine.ambients[ambient].has_gradient)
      model_.notes.push_back("film " + film.id + " takes " + film.ambient + " at its one height, without its gradient");
    if (film.of_temperature || (film.exact_radiation && film.emissivity.value > 0.0)) {
      model_.notes.push_back(
          "film " + film.id +
          " keeps its coefficients at the reference temperature; they do not depend on the surface temperature here");
    }
  }

  void collect_sources() {
    const mesh::Machine& machine = model_.machine();
    std::map<std::pair<std::size_t, int>, Series> at_joint;  // W by joint and side: 0 slave, 1 master
    for (std::size_t s = 0; s < machine.sources.size(); ++s) {
      const mesh::SourceSpec& source = machine.sources[s];
      const Series power = series([&](const Eigen::VectorXd& row) { return operating_.source_powers(row)[s]; });
      if (is_zero(power)) continue;
      const auto on_surface = [&](const std::string& surface, double share) {
        const double area = model_.mesh.surface_area(machine.surface_index(surface));
        if (put(surface, fluxes_.size(), fluxes_of_face_)) fluxes_.push_back({source.id, sum({power}, {share / area})});
      };
      for (const mesh::SourcePlace& place : source.places) {
        if (!place.volume.empty()) {
          if (model_.options.body.empty())
            model_.notes.push_back("source " + source.id + " heats volume " + place.volume + ": left out");
          continue;
        }
        if (place.joint.empty()) {
          on_surface(place.surface, place.share);
          continue;
        }
        const std::size_t j = machine.joint_index(place.joint);
        const mesh::JointSpec& joint = machine.joints[j];
        const bool slave_taken = model_.takes(model_.body_of_surface(machine.surface_index(joint.slave)));
        const bool master_taken =
            !joint.master.empty() && model_.takes(model_.body_of_surface(machine.surface_index(joint.master)));
        if (!joint.master.empty() && slave_taken != master_taken) {
          model_.notes.push_back("source " + source.id + " at joint " + joint.id + " to another body: left out");
          continue;
        }
        if (!slave_taken) continue;
        if (contact_[j].empty()) {  // as the solver has it: nothing touches, the slave keeps the heat
          on_surface(joint.slave, place.share);
          continue;
        }
        const double slave_share = joint.master.empty() ? 1.0 : place.slave_share;
        for (int side = 0; side < 2; ++side) {
          const double share = place.share * (side == 0 ? slave_share : 1.0 - slave_share);
          if (share == 0.0) continue;
          Series& total = at_joint[{j, side}];
          if (total.empty()) total.assign(power.size(), 0.0);
          for (std::size_t k = 0; k < power.size(); ++k) total[k] += share * power[k];
        }
      }
    }
    for (auto& [at, power] : at_joint) {
      const mesh::JointSpec& joint = machine.joints[at.first];
      const int body = model_.body_of_surface(machine.surface_index(at.second == 0 ? joint.slave : joint.master));
      const mesh::TetMesh& mesh = model_.mesh.bodies[body];
      double area = 0.0;
      for (const ContactPoint& point : contact_[at.first]) area += point.area;
      std::map<Index, double> shares;
      for (const ContactPoint& point : contact_[at.first]) {
        const mesh::FaceNodes nodes = mesh::face_nodes(mesh, at.second == 0 ? point.slave_face : point.master_face);
        const mesh::FaceValues values =
            mesh::face_shape(mesh.order(), at.second == 0 ? point.slave_weights : point.master_weights);
        for (Index i = 0; i < nodes.size(); ++i) shares[model_.node(body, nodes[i])] += point.area / area * values[i];
      }
      for (const auto& [node, share] : shares) points_[node].emplace_back(point_fluxes_.size(), share);
      point_fluxes_.push_back({joint.id + (at.second == 0 ? ".slave" : ".master"), std::move(power)});
    }
  }

  Value value(const std::string& kind, const std::string& id, const Series& values) {
    if (is_constant(values)) return {values.front(), ""};
    const std::string name = model_.names.of(kind, id);
    std::vector<std::string> points;
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (i == 0) points.push_back(fmt::format("0, {:.10g}", values[0]));
      const bool inside = i > 0 && i + 1 < values.size() && values[i - 1] == values[i] && values[i] == values[i + 1];
      if (!inside) points.push_back(fmt::format("{:.12g}, {:.10g}", program_.ends[i], values[i]));
    }
    loads_.amplitudes += "*AMPLITUDE, NAME=" + name + ", TIME=TOTAL TIME\n" + wrapped(points, 4);
    return {1.0, name};
  }

  /// Triangles that carry the same items, for each set of items.
  std::map<std::vector<int>, Faces> grouped(const std::map<std::pair<int, int>, std::vector<int>>& of_face) const {
    std::map<std::vector<int>, Faces> groups;
    for (const auto& [face, items] : of_face) {
      const mesh::TetMesh& mesh = model_.mesh.bodies[face.first];
      groups[items][{face.first, element_face(mesh, face.second)}].push_back(
          model_.element(face.first, mesh.face_tet[face.second]));
    }
    return groups;
  }

  /// The elements as sets, one a face number. @return set and face number
  std::vector<std::pair<std::string, int>> sets(const std::string& kind, const std::string& id, const Faces& faces) {
    std::map<int, std::vector<std::string>> of_number;
    for (const auto& [at, elements] : faces)
      for (const Index element : elements) of_number[at.second].push_back(std::to_string(element));
    std::vector<std::pair<std::string, int>> made;
    for (const auto& [number, elements] : of_number) {
      made.emplace_back(model_.names.of(kind, id + "." + std::to_string(number)), number);
      loads_.amplitudes += "*ELSET, ELSET=" + made.back().first + "\n" + wrapped(elements, 10);
    }
    return made;
  }

  template <class Items>
  static std::string joined(const std::vector<int>& group, const Items& items) {
    std::string id;
    for (const int item : group) id += (id.empty() ? "" : "+") + items[item].id;
    return id;
  }

  void write_films() {
    for (const auto& [group, faces] : grouped(films_of_face_)) {
      const std::string id = joined(group, films_);
      Series coefficient(program_.rows.size(), 0.0), sink = coefficient;
      for (std::size_t k = 0; k < coefficient.size(); ++k) {
        for (const int item : group) {
          const Film& film = films_[item];
          coefficient[k] += film.coefficient[k];
          sink[k] += film.coefficient[k] * film.sink[k];
        }
        // One film, or none open: the temperature itself, not its rounded quotient.
        sink[k] = group.size() == 1 || coefficient[k] == 0.0 ? films_[group[0]].sink[k] : sink[k] / coefficient[k];
        loads_.has_level = loads_.has_level || coefficient[k] > 0.0;
      }
      const Value h = value("FILM", id, coefficient), t = value("SINK", id, sink);
      loads_.lines += "** film " + id + "\n*FILM" + (t.amplitude.empty() ? "" : ", AMPLITUDE=" + t.amplitude) +
                      (h.amplitude.empty() ? "" : ", FILM AMPLITUDE=" + h.amplitude) + "\n";
      for (const auto& [set, number] : sets("FILM_SET", id, faces))
        loads_.lines += fmt::format("{}, F{}, {:.10g}, {:.10g}\n", set, number, t.magnitude, h.magnitude);
    }
  }

  void write_fluxes() {
    for (const auto& [group, faces] : grouped(fluxes_of_face_)) {
      const std::string id = joined(group, fluxes_);
      std::vector<Series> all;
      for (const int item : group) all.push_back(fluxes_[item].power);
      const Value q = value("FLUX", id, sum(all, std::vector<double>(all.size(), 1.0)));
      loads_.lines +=
          "** source " + id + ", W/m2\n*DFLUX" + (q.amplitude.empty() ? "" : ", AMPLITUDE=" + q.amplitude) + "\n";
      for (const auto& [set, number] : sets("FLUX_SET", id, faces))
        loads_.lines += fmt::format("{}, S{}, {:.10g}\n", set, number, q.magnitude);
    }
  }

  void write_point_fluxes() {
    std::vector<std::string> lines(point_fluxes_.size()), shared;
    std::vector<Value> values;
    for (const Flux& flux : point_fluxes_) values.push_back(value("POWER", flux.id, flux.power));
    for (const auto& [node, fluxes] : points_) {
      if (fluxes.size() == 1) {
        const auto [flux, share] = fluxes.front();
        lines[flux] += fmt::format("{}, 11, {:.10g}\n", node, share * values[flux].magnitude);
        continue;
      }
      std::vector<Series> all;
      std::vector<double> weights;
      for (const auto& [flux, share] : fluxes) {
        all.push_back(point_fluxes_[flux].power);
        weights.push_back(share);
      }
      const Value q = value("POWER_NODE", std::to_string(node), sum(all, weights));
      shared.push_back("*CFLUX" + (q.amplitude.empty() ? "" : ", AMPLITUDE=" + q.amplitude) +
                       fmt::format("\n{}, 11, {:.10g}\n", node, q.magnitude));
    }
    for (std::size_t f = 0; f < lines.size(); ++f) {
      if (!lines[f].empty()) {
        loads_.lines += "** heat at joint " + point_fluxes_[f].id + ", W\n*CFLUX" +
                        (values[f].amplitude.empty() ? "" : ", AMPLITUDE=" + values[f].amplitude) + "\n" + lines[f];
      }
    }
    for (const std::string& text : shared) loads_.lines += text;
  }

  void note_motion() {
    const bool moves = std::any_of(program_.rows.begin(), program_.rows.end(), [&](const Eigen::VectorXd& row) {
      for (Index i = 0; i < row.size(); ++i)
        if (operating_.channels().names()[i].find(".low_") != std::string::npos && std::isfinite(row[i])) return true;
      return !(operating_.pose(row) - model_.pose).isZero(1e-9);
    });
    if (moves) {
      model_.notes.push_back("axes of the program move or stand elsewhere; the deck keeps them at " +
                             mesh::format_pose(model_.machine(), model_.pose) +
                             ", with joints and frictional heat of that position");
    }
  }

  Model& model_;
  const Program& program_;
  const std::vector<std::vector<ContactPoint>>& contact_;
  const OperatingModel& operating_;
  std::vector<Film> films_;
  std::vector<Flux> fluxes_, point_fluxes_;
  std::map<std::pair<int, int>, std::vector<int>> films_of_face_, fluxes_of_face_;  ///< by body, triangle
  std::map<Index, std::vector<std::pair<std::size_t, double>>> points_;             ///< by node of ccx
  Loads loads_;
};

}  // namespace

Loads loads_text(Model& model, const Program& program, const std::vector<std::vector<ContactPoint>>& contact) {
  return Writer(model, program, contact).text();
}

}  // namespace thermotwin::solver::calculix
