// The error laws: the error of a link, relative to the reference level, is at most
//   factor W tau^n sum_j z_j p(s_j) (q2 / (2 s_j^2))^n = factor W sum_j z_j p(s_j) chi_j^n.

float power_of(uint law) {
    return law == LAW_MAGNITUDE ? 0.0 : law == LAW_MOMENTS ? 0.5 + 0.5 * float(ORDER) : law == LAW_EXPANSION ? 1.5
         : law == LAW_SAMPLE ? max(1.0, float(ORDER)) : 3.0;
}
float factor_of(uint law) {
    bool whole = ORDER == 2;
    if (law == LAW_MOMENTS) return whole ? 0.5 : 1.0;
    if (law == LAW_SAMPLE) return whole ? 1.5 : 0.55;
    return law == LAW_MAGNITUDE ? 1.0 : law == LAW_EXPANSION ? 0.5 : 0.045;
}
