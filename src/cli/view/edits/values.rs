//! Values of the scene with all settings, without reading the whole scene.

use milkglass::scene::{Material, Scene};

use super::Edits;

impl Edits {
    /// The material that an object has with all settings and one more; none for a material with textures or layers,
    /// which only the whole scene can read.
    pub(in super::super) fn material(&self, object: usize, key: &str, value: &str) -> Option<Material> {
        let known = &self.scene.objects[object].material;
        if known.texture.is_some() || known.sigma_0_texture.is_some() || known.layers.is_some() {
            return None;
        }
        let path = |key: &str| format!("object.{object}.material.{key}");
        let text =
            self.scene.written(&self.sets().into_iter().chain([format!("{}={value}", path(key))]).collect::<Vec<_>>());
        let mut table: toml::Table = toml::from_str(&text.ok()?).ok()?;
        let mut own = table.remove("object")?.as_array_mut()?.get_mut(object)?.as_table_mut()?.remove("material")?;
        let (own, unit) = (own.as_table_mut()?, table.remove("unit"));
        let plane = [("shape", "plane".into()), ("detail", 1.into()), ("material", std::mem::take(own).into())];
        let plane: toml::Table =
            plane.into_iter().map(|(key, value): (_, toml::Value)| (key.to_owned(), value)).collect();
        let all =
            [("object".to_owned(), vec![plane].into())].into_iter().chain(unit.map(|unit| ("unit".to_owned(), unit)));
        let text = toml::to_string(&all.collect::<toml::Table>()).ok()?;
        Some(Scene::parse("material", &text, &[]).ok()?.objects.swap_remove(0).material)
    }

    /// The value of a key of the scene with all settings, where it is a number.
    pub(in super::super) fn number(&self, key: &str) -> Option<f64> {
        let mut place = &toml::Value::Table(toml::from_str(&self.written().ok()?).ok()?);
        for part in key.split('.') {
            place = match place {
                toml::Value::Table(table) => table.get(part)?,
                toml::Value::Array(list) => list.get(part.parse::<usize>().ok()?)?,
                _ => return None,
            };
        }
        place.as_float().or_else(|| place.as_integer().map(|whole| whole as f64))
    }
}
