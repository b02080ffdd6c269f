// The error laws: what is left out of a link, relative to the reference level, is at most
//   factor W tau^n sum_j z_j p(s_j) (q2 / (2 s_j^2))^n = factor W sum_j z_j p(s_j) chi_j^n.
const uint LAWS = 5;
const uint ENTRIES = 128;
// Binary orders of magnitude that a table spans at most, and the farthest distance inside a frame.
const float DEEPEST = 60.0;
const float FARTHEST = 4.0;

// 0 magnitude, 1 cluster's moments, 2 block's expansion, 3 triangle's one sample, 4 triangle's 6 area points.
float power_of(uint law) {
    return law == 0 ? 0.0 : law == 1 ? 0.5 + 0.5 * float(ORDER) : law == 2 ? 1.5 : law == 3 ? max(1.0, float(ORDER)) : 3.0;
}
float factor_of(uint law) {
    bool whole = ORDER == 2;
    if (law == 1) return whole ? 0.5 : 1.0;
    if (law == 3) return whole ? 1.5 : 0.55;
    return law == 0 ? 1.0 : law == 2 ? 0.5 : 0.045;
}
// Shares of a link's allowed error: light fainter than the first is left out; the other is what a block's expansion adds.
const float NOTHING = 1e-3;
const float RECEIVER_SHARE = 0.3;
// Largest chi at which a triangle is taken by one sample and by 6 area points.
const float SAMPLE_CHI = 1.4;
const float AREA_CHI = 1.4;
