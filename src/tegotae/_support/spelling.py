"""Letters and signs that ASCII lacks, as it can spell them."""

IN_ASCII = {
    **{"φ": "phi", "ω": "omega", "σ": "sigma", "α": "alpha", "κ": "kappa", "ψ": "psi", "π": "pi"},
    **{"δ": "delta", "τ": "tau", "η": "eta", "θ": "theta", "ρ": "rho", "Ω": "Omega", "μ": "mu"},
    **{"′": "'", "·": "*", "≤": "<=", "≥": ">=", "∈": "in", "Σ": "sum", "√": "sqrt", "²": "^2"},
    **{"½": "1/2", "−": "-", "–": "-", "…": "...", "∞": "inf", "`": "", "Δ": "Delta", "β": "beta"},
    **{"φ̇": "phi_dot", "ẏ": "y_dot", "ȧ": "a_dot", "×": "x", "∘": "*", "≠": "!="},
}
