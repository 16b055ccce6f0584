// Units that snapshots in HDF5 state, and what else they say of their simulation.
// Sources: V. Springel et al., GADGET-4 (2021), section on file formats (a_scaling, ..., to_cgs); the guide of SWIFT
// (2024), section on snapshots (exponents of units); the EAGLE simulations' particle data (2017; aexp-scale-exponent).
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "src/input/snapshot/hdf5_file.h"

namespace tessera::snapshot {

// The unit of a table as its attributes state it: a factor to units of cgs, with powers of the scale factor a and of h,
// "3.08568e+24 a h^-1 cm". "" when they state none, or when the table has no unit.
std::string unit_of_table(const Hdf5File& file, const std::string& group, const std::string& table);

// Numbers of the header and of the groups of parameters, units and cosmology, under one name for each: time, redshift,
// hubble (h), omega_matter, omega_lambda; unit_length_cgs, unit_mass_cgs, unit_velocity_cgs, unit_time_cgs.
std::vector<std::pair<std::string, double>> stated_numbers(const Hdf5File& file);

}  // namespace tessera::snapshot
